"""A scene that has been read and validated."""

import shlex
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from hashlib import sha256
from typing import TYPE_CHECKING, Any

from chaosdrill.errors import ChaosdrillError, SettingsError
from chaosdrill.files import name_text
from chaosdrill.names import remedy
from chaosdrill.scene.check_made import DriveFault, driven_system, halved_system, noisy_system
from chaosdrill.scene.defined import Recipe
from chaosdrill.scene.lines import InvalidSceneError, Problem, problems_of
from chaosdrill.settings import KeyPath, Known
from chaosdrill.systems.drill.si import ReadSI

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem
    from chaosdrill.scene.checks import Asked

STDIN, PIPED = "-", "stdin"
"""Name of standard input on the command line, and of a scene from there in messages."""


@dataclass(frozen=True)
class Scene:
    """The contents of a scene file.

    Parameters
    ----------
    name : str
        Name of the file.
    text : str
        The file's whole text.
    title : str
        Its title; without one, the file's name.
    model : str
        Name of the system in the library; empty for a system that the scene defines.
    definition : mapping or None
        Equations of a system that the scene defines itself.
    drives : mapping of str to mapping
        Drives with corners and jumps, by the parameter that each replaces; arguments of `chaosdrill.driven`.
    noise : mapping
        Parameters drawn anew at events, and ``seed``; arguments of `HybridSystem.with_noise`.
    symmetry : mapping of str to str
        Images of the states that a symmetry changes, by which the system is followed over half of its motion; argument
        of `chaosdrill.halved`.
    effects : mapping of str to str
        Effects simulated; those left out are not.
    parameters : mapping of str to float
        Dimensionless parameters that the scene sets, those made from SI quantities among them.
    initial : mapping
        Initial values that it sets, and ``mode``.
    si : ReadSI
        The quantities of a scene in SI units, the parameters made of them, and the scales; else empty.
    numerics : mapping of str to value
        Arguments for method and tolerance that it gives.
    analyses : mapping of str to Asked
        The requested analyses, by group of the archive.
    lines : mapping of path to int
        Line of each key in the file, 0 for one set from outside.
    changes : mapping of str to str
        Keys that were set from outside, with their values in TOML; the text already contains them.
    """

    name: str
    text: str = field(repr=False)
    title: str
    model: str
    definition: Mapping[str, Any] | None
    drives: Mapping[str, Any]
    noise: Mapping[str, Any]
    symmetry: Mapping[str, str]
    effects: Mapping[str, str]
    parameters: Mapping[str, float]
    initial: Mapping[str, Any]
    si: ReadSI
    numerics: Mapping[str, Any]
    analyses: Mapping[str, "Asked"]
    lines: Mapping[KeyPath, int] = field(repr=False)
    changes: Mapping[str, str] = field(default_factory=dict)

    @property
    def scales(self) -> Mapping[str, float]:
        """``time_s``, ``length_m`` and ``force_N`` of one dimensionless unit, for a scene in SI units; else empty."""
        return self.si.scales

    @property
    def sha256(self) -> str:
        """SHA-256 of the text in UTF-8."""
        return sha256(self.text.encode()).hexdigest()

    @cached_property
    def system(self) -> "HybridSystem":
        """The system, built on first use.

        Raises
        ------
        SceneError
            If it cannot be built, or if the scene names modes or events that it does not have.
        """
        tables = (self.definition, self.effects, self.parameters, self.initial, self.drives, self.symmetry)
        one = Recipe(self.model, *tables)
        listed = bool(self.drives or self.symmetry) and not self.noise
        system = one.before() if listed else None
        if system is None:
            system = self._made(one)
            if listed and (key := one.key) is not None:
                system = system.enlisted(key)
        checks = (self._check_modes, self._check_reached, self._check_fit)
        if problems := [one for check in checks for one in check(system)]:
            raise InvalidSceneError(self.name, problems, self.lines)
        return system

    def _made(self, one: Recipe) -> "HybridSystem":
        with self._placed():
            system = one.undriven(kept=not self.drives)
        if "mode" in self.initial:
            if problems := self._unknown_modes(system, {("system", "initial", "mode"): self.initial["mode"]}):
                raise InvalidSceneError(self.name, problems, self.lines)
            system = system.with_initial(mode=self.initial["mode"])
        with self._placed("drives"):
            system = driven_system(system, self.drives)
        with self._placed("noise"):
            system = noisy_system(system, self.noise)
        with self._placed("symmetry"):
            return halved_system(system, self.symmetry)

    @contextmanager
    def _placed(self, *table: str) -> Iterator[None]:
        """Give a fault of the block the line of a table of the system, or of the drive that it names."""
        try:
            yield
        except ChaosdrillError as fault:
            path = ("system", *table, *([fault.drive] if isinstance(fault, DriveFault) else []))
            raise InvalidSceneError(self.name, [Problem(path, str(fault))], self.lines) from fault

    def check_period(self) -> None:
        """Refuse a scene whose parameters make the forcing period infinite, zero or negative, before anything is run.

        Raises `SceneError`, with the lines of the parameters that decide on the period.
        """
        try:
            self.system.forcing_period()
        except SettingsError as fault:
            period = self.system.period
            names = sorted(p.name for p in period.free_symbols) if period is not None else []
            places: list[KeyPath] = [place for name in names if (place := ("system", "parameters", name)) in self.lines]
            problems = [Problem(place, str(fault)) for place in places or [("system",)]]
            raise InvalidSceneError(self.name, problems, self.lines) from fault

    def fingerprint(self) -> dict[str, Any]:
        """Everything that determines the numbers, versions included, but not the title or the layout of the file."""
        from chaosdrill.sweep.fingerprint import origin

        return {
            "system": {
                "model": self.model,
                **({} if self.definition is None else {"definition": self.definition, "modes": [*self.system.modes]}),
                **{name: made for name in ("drives", "noise", "symmetry") if (made := getattr(self, name))},
                "effects": self.effects,
                "parameters": self.parameters,
                "initial": self.initial,
                "scales": self.scales,
            },
            "numerics": dict(self.numerics),
            "analysis": {group: {"kind": asked.kind, **asked.table} for group, asked in self.analyses.items()},
            **origin(),
        }

    def command(self, *more: str) -> str:
        """The command ``run`` with this scene, its changes, and further arguments."""
        sets = [part for key, value in self.changes.items() for part in ("--set", f"{key}={value}")]
        return shlex.join(["run", STDIN if self.name == PIPED else self.name, *sets, *map(name_text, more)])

    def _check_modes(self, system: "HybridSystem") -> list[Problem]:
        places: dict[KeyPath, Any] = {}
        for group, analysis in self.analyses.items():
            for index, seed in enumerate(analysis.get("seeds") or ()):
                places["analysis", group, "seeds", index, "mode"] = seed.get("mode")
            places["analysis", group, "random", "mode"] = (analysis.get("random") or {}).get("mode")
        return self._unknown_modes(system, places)

    @staticmethod
    def _unknown_modes(system: "HybridSystem", places: Mapping[KeyPath, Any]) -> list[Problem]:
        return [
            Problem(place, f"unknown mode {mode!r:.60}; {remedy(mode, system.modes)}")
            for place, mode in places.items()
            if mode is not None and mode not in system.modes
        ]

    def _check_reached(self, system: "HybridSystem") -> list[Problem]:
        """Check that every mode is reached; an unreached mode suggests a misspelt transition."""
        if ("system", "definition") not in self.lines or self.drives:
            return []
        starts = [self.initial.get("mode"), system.mode_names[0], *system.regions]
        for analysis in self.analyses.values():
            starts += [seed.get("mode") for seed in (*(analysis.get("seeds") or ()), analysis.get("random") or {})]
        reached: set[Any] = set()
        found = set(starts)
        while found - reached:
            reached |= found
            found = {t.target for t in system.transitions if reached & set(t.source)}
        return [
            Problem(
                ("system", "definition", "modes", mode),
                "no transition leads to it and no run starts in it; add one, or leave the mode out",
            )
            for mode in system.modes
            if mode not in reached
        ]

    def _check_fit(self, system: "HybridSystem") -> list[Problem]:
        """Check that the system has the sections, counts the lengths, and has not lost a parameter to its symmetry."""
        known = Known.of(system) if self.symmetry else None
        problems: list[Problem] = []
        for group, asked in self.analyses.items():
            settings = asked.entry.settings
            found = [*settings.misfits(asked.table, system), *settings.noise_faults(system)]
            found += settings.faults(asked.table, known) if known else ()
            problems += problems_of(found, ("analysis", group))
        return problems
