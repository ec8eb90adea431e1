"""A root folder with the files of some Debian packages and no other, in which programs run as on a machine without compiler."""
import os
import subprocess

# Read by people only.
_LEFT_OUT = ("/usr/share/doc/", "/usr/share/man/", "/usr/share/locale/", "/usr/share/info/")
# Nothing of the environment gets in. /proc tells a program where it stands; its own process table needs its own /proc.
_ENTER = """
mount -t proc proc "$0/proc" && mount --rbind /dev "$0/dev" && mount -t tmpfs tmpfs "$0/tmp" || exit 125
exec chroot "$0" /usr/bin/env -i PATH=/usr/bin HOME=/tmp "$@"
"""


def build(root, files):
    """`files` as packages list them. Links of folders (/lib and the like) come first, so that nothing is unpacked beside them."""
    for folder in ("usr/bin", "usr/sbin", "usr/lib", "usr/lib64", "proc", "dev", "tmp"):
        os.makedirs(f"{root}/{folder}", exist_ok=True)
    for link in ("bin", "sbin", "lib", "lib64"):
        os.symlink(f"usr/{link}", f"{root}/{link}")
    names = [path[1:] for path in sorted(files) if os.path.lexists(path) and not path.startswith(_LEFT_OUT)]
    pack = subprocess.Popen(["tar", "-C", "/", "-c", "--no-recursion", "--null", "-T", "-"],
                            stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    unpack = subprocess.Popen(["tar", "-C", root, "-x", "--keep-directory-symlink"], stdin=pack.stdout)
    pack.stdin.write(b"\0".join(os.fsencode(name) for name in names))
    pack.stdin.close()
    if unpack.wait() or pack.wait():
        raise RuntimeError(f"cannot copy the packages' files to {root}")


def enter(root):
    """The words before a command that run it inside. As another user than root it becomes root of a namespace of its own."""
    become_root = [] if os.geteuid() == 0 else ["--user", "--map-root-user"]
    return ["unshare", *become_root, "--mount", "--pid", "--fork", "--kill-child", "sh", "-c", _ENTER, root]


def why_not(root):
    """Why nothing can run inside; empty: it can."""
    tried = subprocess.run([*enter(root), "true"], capture_output=True, text=True)
    return tried.stderr.strip() if tried.returncode else ""
