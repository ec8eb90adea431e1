"""What this machine's Debian packages need and which files they own."""
import re
import subprocess

_FIELDS = "${Package}\t${db:Status-Status}\t${Essential}\t${Pre-Depends}, ${Depends}\t${Provides}\n"


def ask(*words):
    return subprocess.run(words, check=True, capture_output=True, text=True).stdout


def merged(path):
    """Debian 12 has /bin, /lib and /sbin as links into /usr; packages and programs name files either way."""
    return "/usr" + path if re.match(r"/(bin|sbin|lib\w*)/", path) else path


def relations(field):
    """[[name, name], ...]: of each inner list one is enough."""
    clauses = [clause for clause in field.split(",") if clause.strip()]
    return [[re.split(r"[ (:]", name.strip())[0] for name in clause.split("|")] for clause in clauses]


class Packages:
    def __init__(self):
        self._needs, self._providers, self.essential = {}, {}, []
        for row in ask("dpkg-query", "-W", "-f", _FIELDS).splitlines():
            name, status, essential, needs, provides = row.split("\t")
            if status != "installed":
                continue
            self._needs[name] = relations(needs)
            if essential == "yes":
                self.essential.append(name)
            for (virtual,) in relations(provides):
                self._providers.setdefault(virtual, name)

    def closure(self, field):
        """The packages that a field like Depends names, and all that those need. Raises LookupError for one that is not here."""
        found, wanted = set(), relations(field)
        while wanted:
            package = self._choose(wanted.pop())
            if package not in found:
                found.add(package)
                wanted += self._needs[package]
        return found

    def _choose(self, alternatives):
        for name in alternatives:
            if name in self._needs:
                return name
            if name in self._providers:
                return self._providers[name]
        raise LookupError(f"the package '{' | '.join(alternatives)}' is not installed here")


def files_of(packages):
    return {merged(path) for path in ask("dpkg", "-L", *sorted(packages)).splitlines() if path.startswith("/")}
