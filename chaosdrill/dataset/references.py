"""The literature behind a result: what is to be cited for a kind of analysis, a method and a system."""

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Reference:
    """One entry of a list of references.

    Parameters
    ----------
    key : str
        Short name, also that of the BibTeX entry.
    authors : str
        Separated by " and ", initials first.
    year : int or None
        Of publication; None if it is not known.
    title : str
        Of the work.
    where : str
        Journal, book with its publisher, or publisher.
    volume : str
        Of a journal.
    pages : str
        First and last.
    doi : str
        Without the resolver's address; empty if there is none.
    entry : {"article", "book", "inproceedings", "software", "misc"}
        Kind of BibTeX entry.
    """

    key: str
    authors: str
    year: int | None
    title: str
    where: str
    volume: str = ""
    pages: str = ""
    doi: str = ""
    entry: str = "article"

    def text(self) -> str:
        """The reference for people.

        Returns
        -------
        str
            One line.
        """
        names = self.authors.split(" and ")
        authors = ", ".join(names[:-1]) + " and " + names[-1] if len(names) > 1 else names[0]
        place = ", ".join(part for part in (f"{self.where} {self.volume}".rstrip(), self.pages) if part)
        parts = [f"{authors} ({self.year})" if self.year else authors, self.title, place]
        line = ". ".join(part for part in parts if part)
        return f"{line}. doi:{self.doi}" if self.doi else f"{line}."

    def bibtex(self) -> str:
        """The reference for BibTeX.

        Returns
        -------
        str
            An entry, of several lines.
        """
        place = {"article": "journal", "book": "publisher", "inproceedings": "booktitle"}.get(
            self.entry, "howpublished"
        )
        authors = " and ".join(_in_bibtex(name) for name in self.authors.split(" and "))
        fields = {"author": authors, "title": f"{{{self.title}}}", place: self.where, "year": self.year}
        fields |= {"volume": self.volume, "pages": self.pages.replace("-", "--"), "doi": self.doi}
        body = ",\n".join(f"  {name} = {{{value}}}" for name, value in fields.items() if value).replace("&", r"\&")
        return f"@{'misc' if self.entry == 'software' else self.entry}{{{self.key},\n{body}\n}}"


def _in_bibtex(name: str) -> str:
    """The name with braces where BibTeX would take part of what follows the initials for a further given name."""
    words = name.split()
    initials = [word for word in words if word.endswith(".")]
    family = " ".join(words[len(initials) :])
    return " ".join([*initials, f"{{{family}}}" if " " in family and family[0].isupper() else family])


_ENTRIES = (
    Reference(
        "benettin1980",
        "G. Benettin and L. Galgani and A. Giorgilli and J.-M. Strelcyn",
        1980,
        "Lyapunov characteristic exponents for smooth dynamical systems and for Hamiltonian systems; a method for "
        "computing all of them. Part 2: Numerical application",
        "Meccanica",
        volume="15",
        pages="21-30",
        doi="10.1007/BF02128237",
    ),
    Reference(
        "mueller1995",
        "P. C. Müller",
        1995,
        "Calculation of Lyapunov exponents for dynamic systems with discontinuities",
        "Chaos, Solitons & Fractals",
        volume="5",
        pages="1671-1681",
        doi="10.1016/0960-0779(94)00170-U",
    ),
    Reference(
        "flyvbjerg1989",
        "H. Flyvbjerg and H. G. Petersen",
        1989,
        "Error estimates on averages of correlated data",
        "The Journal of Chemical Physics",
        volume="91",
        pages="461-466",
        doi="10.1063/1.457480",
    ),
    Reference(
        "kaplan1979",
        "J. L. Kaplan and J. A. Yorke",
        1979,
        "Chaotic behavior of multidimensional difference equations",
        "Functional Differential Equations and Approximation of Fixed Points, Lecture Notes in Mathematics 730, "
        "Springer",
        pages="204-227",
        doi="10.1007/BFb0064319",
        entry="inproceedings",
    ),
    Reference(
        "smith1987",
        "D. A. Smith and W. F. Ford and A. Sidi",
        1987,
        "Extrapolation methods for vector sequences",
        "SIAM Review",
        volume="29",
        pages="199-233",
        doi="10.1137/1029042",
    ),
    Reference(
        "das2017",
        "S. Das and Y. Saiki and E. Sander and J. A. Yorke",
        2017,
        "Quantitative quasiperiodicity",
        "Nonlinearity",
        volume="30",
        pages="4111-4140",
        doi="10.1088/1361-6544/aa84c2",
    ),
    Reference(
        "dankowicz2013",
        "H. Dankowicz and F. Schilder",
        2013,
        "Recipes for Continuation",
        "SIAM",
        doi="10.1137/1.9781611972573",
        entry="book",
    ),
    Reference(
        "dercole2005",
        "F. Dercole and Yu. A. Kuznetsov",
        2005,
        "SlideCont: an Auto97 driver for bifurcation analysis of Filippov systems",
        "ACM Transactions on Mathematical Software",
        volume="31",
        pages="95-119",
        doi="10.1145/1055531.1055536",
    ),
    Reference(
        "dibernardo2008",
        "M. di Bernardo and C. J. Budd and A. R. Champneys and P. Kowalczyk",
        2008,
        "Piecewise-smooth Dynamical Systems: Theory and Applications",
        "Springer",
        doi="10.1007/978-1-84628-708-4",
        entry="book",
    ),
    Reference(
        "keller1977",
        "H. B. Keller",
        1977,
        "Numerical solution of bifurcation and nonlinear eigenvalue problems",
        "Applications of Bifurcation Theory, Academic Press",
        pages="359-384",
        entry="inproceedings",
    ),
    Reference(
        "auerbach1987",
        "D. Auerbach and P. Cvitanović and J.-P. Eckmann and G. Gunaratne and I. Procaccia",
        1987,
        "Exploring chaotic motion through periodic orbits",
        "Physical Review Letters",
        volume="58",
        pages="2387-2389",
        doi="10.1103/PhysRevLett.58.2387",
    ),
    Reference(
        "feigenbaum1978",
        "M. J. Feigenbaum",
        1978,
        "Quantitative universality for a class of nonlinear transformations",
        "Journal of Statistical Physics",
        volume="19",
        pages="25-52",
        doi="10.1007/BF01020332",
    ),
    Reference(
        "bulirsch1966",
        "R. Bulirsch and J. Stoer",
        1966,
        "Numerical treatment of ordinary differential equations by extrapolation methods",
        "Numerische Mathematik",
        volume="8",
        pages="1-13",
        doi="10.1007/BF02165234",
    ),
    Reference(
        "jorba2005",
        "À. Jorba and M. Zou",
        2005,
        "A software package for the numerical integration of ODEs by means of high-order Taylor methods",
        "Experimental Mathematics",
        volume="14",
        pages="99-117",
        doi="10.1080/10586458.2005.10128904",
    ),
    Reference(
        "farouki2012",
        "R. T. Farouki",
        2012,
        "The Bernstein polynomial basis: a centennial retrospective",
        "Computer Aided Geometric Design",
        volume="29",
        pages="379-419",
        doi="10.1016/j.cagd.2012.03.001",
    ),
    Reference(
        "hairer1993",
        "E. Hairer and S. P. Nørsett and G. Wanner",
        1993,
        "Solving Ordinary Differential Equations I: Nonstiff Problems",
        "2nd edition, Springer",
        doi="10.1007/978-3-540-78862-1",
        entry="book",
    ),
    Reference("drilling", "", None, "System for percussive drilling with rock model", "", entry="misc"),
    Reference(
        "hunt1975",
        "K. H. Hunt and F. R. E. Crossley",
        1975,
        "Coefficient of restitution interpreted as damping in vibroimpact",
        "Journal of Applied Mechanics",
        volume="42",
        pages="440-445",
        doi="10.1115/1.3423596",
    ),
    Reference(
        "shaw1983",
        "S. W. Shaw and P. J. Holmes",
        1983,
        "A periodically forced piecewise linear oscillator",
        "Journal of Sound and Vibration",
        volume="90",
        pages="129-155",
        doi="10.1016/0022-460X(83)90407-8",
    ),
    Reference(
        "leine2004",
        "R. I. Leine and H. Nijmeijer",
        2004,
        "Dynamics and Bifurcations of Non-Smooth Mechanical Systems",
        "Springer",
        doi="10.1007/978-3-540-44398-8",
        entry="book",
    ),
    Reference(
        "luck1993",
        "J. M. Luck and A. Mehta",
        1993,
        "Bouncing ball with a finite restitution: chattering, locking, and chaos",
        "Physical Review E",
        volume="48",
        pages="3988-3997",
        doi="10.1103/PhysRevE.48.3988",
    ),
    Reference(
        "mcgeer1990",
        "T. McGeer",
        1990,
        "Passive dynamic walking",
        "The International Journal of Robotics Research",
        volume="9",
        pages="62-82",
        doi="10.1177/027836499000900206",
    ),
    Reference(
        "roessler1976",
        "O. E. Rössler",
        1976,
        "An equation for continuous chaos",
        "Physics Letters A",
        volume="57",
        pages="397-398",
        doi="10.1016/0375-9601(76)90101-8",
    ),
    Reference(
        "matsumoto1984",
        "T. Matsumoto",
        1984,
        "A chaotic attractor from Chua's circuit",
        "IEEE Transactions on Circuits and Systems",
        volume="31",
        pages="1055-1058",
        doi="10.1109/TCS.1984.1085459",
    ),
    Reference(
        "lorenz1963",
        "E. N. Lorenz",
        1963,
        "Deterministic nonperiodic flow",
        "Journal of the Atmospheric Sciences",
        volume="20",
        pages="130-141",
        doi="10.1175/1520-0469(1963)020<0130:DNF>2.0.CO;2",
    ),
    Reference(
        "denhartog1931",
        "J. P. Den Hartog",
        1931,
        "Forced vibrations with combined Coulomb and viscous friction",
        "Transactions of the ASME",
        volume="53",
        pages="107-115",
    ),
)

REFERENCES = {entry.key: entry for entry in _ENTRIES}

_SPECTRUM = ("benettin1980", "mueller1995", "flyvbjerg1989")
_POINTS = (*_SPECTRUM, "smith1987", "das2017")
_ORBITS = ("mueller1995", "dankowicz2013", "dercole2005", "dibernardo2008")

BY_KIND: dict[str, tuple[str, ...]] = {
    "trajectory": (),
    "poincare-section": ("mueller1995",),
    "lyapunov-spectrum": (*_SPECTRUM, "kaplan1979"),
    "bifurcation-diagram": _POINTS,
    "parameter-chart": _POINTS,
    "basins": _POINTS,
    "periodic-orbit": _ORBITS,
    "continuation": (*_ORBITS, "keller1977"),
    "work-precision": (*_SPECTRUM, "bulirsch1966"),
}

BY_METHOD: dict[str, tuple[str, ...]] = {
    "taylor": ("jorba2005", "farouki2012"),
    "dop853": ("hairer1993", "farouki2012"),
    "rk4": (),
}

BY_SYSTEM: dict[str, tuple[str, ...]] = {
    "percussive-drill": ("drilling",),
    "percussive-drill-5d": ("drilling",),
    "impact-oscillator": ("shaw1983",),
    "belt-stick-slip": ("leine2004",),
    "bouncing-ball": ("luck1993",),
    "rimless-wheel": ("mcgeer1990",),
    "roessler": ("roessler1976",),
    "chua": ("matsumoto1984",),
    "lorenz": ("lorenz1963",),
    "den-hartog": ("denhartog1931",),
}


def package() -> Reference:
    """How this package is cited."""
    import chaosdrill

    return Reference(
        "chaosdrill",
        "The chaosdrill developers",
        2026,
        "chaosdrill: event-accurate simulation and Lyapunov spectra of hybrid systems",
        f"version {chaosdrill.__version__}",
        entry="software",
    )


def references(attributes: Mapping[str, Any], variables: Iterable[str] = ()) -> tuple[Reference, ...]:
    """What is to be cited for one result, this package apart.

    Parameters
    ----------
    attributes : mapping
        Attributes of the dataset: ``kind``, ``method``, ``system`` and ``settings`` (JSON) are looked at; what is
        absent or unknown adds nothing.
    variables : iterable of str, optional
        Names of its variables: some methods are used only where their results are there.

    Returns
    -------
    tuple of Reference
        In the order analysis, method, system.
    """
    present = set(variables)
    settings = mapping(attributes.get("settings"))
    kind, method, system = (str(attributes.get(name, "")) for name in ("kind", "method", "system"))
    keys = [*BY_KIND.get(kind, ())]
    if settings.get("start") == "search":
        keys.append("auerbach1987")
    if "feigenbaum_ratio" in present:
        keys.append("feigenbaum1978")
    if kind in ("bifurcation-diagram", "parameter-chart") and "lyapunov_exponent" not in present:
        keys = [key for key in keys if key not in _SPECTRUM]
    several = settings.get("methods")
    for name in (method, *(several if isinstance(several, list) else ())):
        keys += BY_METHOD.get(str(name), ())
    keys += BY_SYSTEM.get(system, ())
    if _hits_as_hunt_and_crossley(attributes):
        keys.append("hunt1975")
    return tuple(REFERENCES[key] for key in dict.fromkeys(keys))


def _hits_as_hunt_and_crossley(attributes: Mapping[str, Any]) -> bool:
    """Whether the system is a drill whose contact is Hunt and Crossley's: only that has an exponent and a stiffness."""
    parameters = mapping(attributes.get("parameters"))
    return str(attributes.get("system", "")).startswith("percussive-drill") and {"n", "k"} <= parameters.keys()


def mapping(text: Any) -> dict[str, Any]:
    """The mapping that a JSON text holds; empty if it holds none."""
    try:
        value = json.loads(text)
    except (TypeError, ValueError, RecursionError):
        return {}
    return value if isinstance(value, dict) else {}
