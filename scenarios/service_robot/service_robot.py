"""How the servicer of `service_robot` looks, millimetres; service_robot.scad is what is touched. Its arms: ../parts/arm.py."""
from visual import details, pictures, shapes
from visual import materials as m
from visual.model import Model
from visual.shapes import Frame, facing

BUS, SEATS, SEAT_R, SEAT_H = (600, 500, 400), (-150, 150), 55, 31


def servicer():
    model = Model()
    sheet = pictures.Sheet(512, 256, 2.0)
    label = m.labels(sheet)
    w, h, d = BUS
    top = d / 2
    details.frame_and_blankets(model, w, h, d, Frame((0, 0, top)))
    model.add(m.ALUMINIUM, shapes.extruded([shapes.rounded(shapes.rectangle(w, h), 0.4)], top - 10, top, 0.4), Frame())
    for y in SEATS:
        seat = Frame((0, y, top))
        model.add(m.GREY, shapes.turned([(SEAT_R, 0), (SEAT_R, SEAT_H - 1), (0, SEAT_H - 1)], 48, 0.4), seat)
        details.screws(model, [(62, 0, 0)], 5.0, seat)
        for k in range(10):
            details.screws(model, [(66, 0, 0)], 5.0, seat.turned(36.0 * k))
        model.add(label, shapes.decal(50, 10, sheet.plate(50, 10, [("ARM L" if y > 0 else "ARM R", 0.56)])), seat.at(-90, 0, 0.06).turned(-90))
    for y in (-60, 60):
        for x in (-200, 200):
            model.add(label, shapes.decal(40, 40, sheet.marker(40, 0x53A9 if x > 0 else 0x96C5)), Frame((x, y, top + 0.06)))
    model.add(label, shapes.decal(160, 26, sheet.plate(160, 26, [("SERVICER 1  VR-OOS", 0.46)], (0.04, 0.06, 0.10), frame=False)),
              Frame((200, 0, top + 0.06)).turned(90))
    details.screws(model, [(x, y, top) for x in range(-280, 281, 80) for y in (-238, 238)], 5.0)
    for s in (-1, 1):
        for x in (-200, 200):
            details.thruster(model, facing((x, s * (h / 2 - 4), 90), (0, s, 0.25)))
    details.handrail(model, (270, -110, top), (270, 110, top), 40)
    return model


PARTS = {"service_robot/meshes/servicer.glb": servicer}
