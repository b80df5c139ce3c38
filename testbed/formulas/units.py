"""Units of coefficients: products of powers of N·m, s and rad."""

from __future__ import annotations

from dataclasses import dataclass

_RAISED = {1: "", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶"}


@dataclass(frozen=True, kw_only=True)
class Unit:
    """Powers of N·m, s and rad."""

    N_m: int = 0
    s: int = 0
    rad: int = 0

    def __mul__(self, other: Unit) -> Unit:
        return Unit(N_m=self.N_m + other.N_m, s=self.s + other.s, rad=self.rad + other.rad)

    def __truediv__(self, other: Unit) -> Unit:
        return Unit(N_m=self.N_m - other.N_m, s=self.s - other.s, rad=self.rad - other.rad)

    def __str__(self) -> str:
        above, below = self._parts(_RAISED)
        if not above and not below:
            return "1"
        return "/".join(["·".join(above) or "1", *below])

    @property
    def suffix(self) -> str:
        """As the end of a name in files, e.g. `N_m_s2_rad2`."""
        above, below = self._parts({power: str(power) if power > 1 else "" for power in _RAISED})
        return "_".join([*above, *below]).replace("·", "_") or "1"

    def _parts(self, raised: dict[int, str]) -> tuple[list[str], list[str]]:
        powers = {"N·m": self.N_m, "s": self.s, "rad": self.rad}
        above = [f"{name}{raised[power]}" for name, power in powers.items() if power > 0]
        return above, [f"{name}{raised[-power]}" for name, power in powers.items() if power < 0]
