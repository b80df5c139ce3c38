"""From the text of a formula to its law, by recursive descent; nothing of the text is ever executed.

law      = [memory "("] product ["," constant ")"]          memory: lag, delay, hysteresis
product  = factor {"*" factor}
factor   = "1" | quantity ["^" ("2" | "3")] | "abs(" quantity ")" | "norm(w)"
         | ("sin" | "cos") "(" ("2*pi*" constant "*t" | gimbal angle) ")"
         | ("pulse" | "once") "(" constant "," constant ")"
constant = a positive number | a name of one that is estimated
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Sequence
from typing import NoReturn, cast

from testbed.errors import InputError
from testbed.formulas.law import BELLS, MOST_FACTORS, Constant, Factor, Function, Law, Memory
from testbed.formulas.motion import ELAPSED, GIMBALS, QUANTITIES, RATES, TIME

MEMORIES = ("lag", "delay", "hysteresis")
FUNCTIONS = ("abs", "norm", "sin", "cos", "pulse", "once")
CONSTANTS = ("f", "tau", "late", "stretch", "at", "width")
"""Constants that are estimated: frequency, lag, delay, stretch of a hysteresis, instant and width of a pulse."""
_TOKEN = re.compile(r"\s*(\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?|[A-Za-z]\w*|\*\*|[-+*/^(),|])")
_LONGEST = 200
"""Characters of a formula; the longest of three factors with a memory has 80."""


def parsed(text: str, *, named_constants: bool = False) -> Law:
    """Return the law that a text says.

    Args:
        text: e.g. `w_x*w_y` or `lag(w_z, 0.3)`.
        named_constants: whether a constant may be a name, which is then estimated.

    Raises:
        InputError: the text is no formula; the message has the place and the nearest name.
    """
    return _Parser(text, named_constants=named_constants).law()


class _Parser:
    def __init__(self, text: str, *, named_constants: bool) -> None:
        self._text, self._named = text, named_constants
        self._tokens: list[tuple[int, str]] = []
        place = 0
        if len(text) > _LONGEST:
            raise InputError(f"a formula of {len(text)} characters: write at most {_LONGEST}")
        while text[place:].strip():
            match = _TOKEN.match(text, place)
            if match is None:
                at = place + len(text[place:]) - len(text[place:].lstrip())
                self._refuse_at(at, f"{text[at]!r} stands in no formula", "write names, numbers, *, ^ and brackets")
            self._tokens.append((match.start(1), match[1]))
            place = match.end()
        self._next = 0

    def law(self) -> Law:
        memory, factors, constant = "", list[Factor](), None
        if self._ahead in MEMORIES:
            memory = self._take()
            self._expect("(")
            factors = self._product()
            self._expect(",")
            constant = self._constant()
            self._expect(")")
        else:
            factors = self._product()
        if self._ahead:
            advice = "a sum is several tables, each with a law of its own" if self._ahead in "+-" else "join by *"
            self._refuse(f"{self._ahead!r} after the end of the formula", advice)
        return Law.of(*factors, memory=cast(Memory, memory), memory_constant=constant)

    def _product(self) -> list[Factor]:
        factors = self._factor()
        while self._ahead == "*":
            self._take()
            factors += self._factor()
        if len(factors) > MOST_FACTORS:
            self._refuse_at(0, f"a product of {len(factors)} factors", f"write at most {MOST_FACTORS}")
        return factors

    def _factor(self) -> list[Factor]:
        if self._ahead == "1":
            self._take()
            return []
        if self._ahead == "|":
            return [self._bars()]
        if self._ahead in FUNCTIONS:
            return [self._function(cast(Function, self._take()))]
        factor = Factor(argument=self._quantity(QUANTITIES))
        if self._ahead not in ("^", "**"):
            return [factor]
        self._take()
        power = self._take()
        if power not in ("2", "3"):
            self._next -= 1
            self._refuse(f"the power {power!r}", "write ^2 or ^3")
        return [factor] * int(power)

    def _bars(self) -> Factor:
        """|w| is the norm, |w_x| the size of one component."""
        self._take()
        name = self._take() if self._ahead == "w" else self._quantity(QUANTITIES)
        self._expect("|")
        return Factor(function="norm" if name == "w" else "abs", argument=name)

    def _function(self, function: Function) -> Factor:
        self._expect("(")
        constants: tuple[Constant, ...] = ()
        if function == "norm":
            argument = self._take()
            if argument != "w":
                self._next -= 1
                self._refuse(f"the norm of {argument!r}", "write norm(w), the length of the body rate")
        elif function == "abs":
            argument = self._quantity(QUANTITIES)
        elif function in BELLS:
            argument, constants = ELAPSED if function == "once" else TIME, (self._constant(),)
            self._expect(",")
            constants += (self._constant(),)
        elif self._ahead == "2":
            for part in ("2", "*", "pi", "*"):
                self._expect(part)
            argument, constants = TIME, (self._constant(),)
            self._expect("*")
            self._expect("t")
        else:
            argument = self._quantity(GIMBALS, f"write {function}(2*pi*0.8*t) or {function}(gimbal_1)")
        self._expect(")")
        return Factor(function=function, argument=argument, constants=constants)

    def _quantity(self, allowed: Sequence[str], otherwise: str = "") -> str:
        name = self._take()
        if name in allowed:
            return name
        self._next -= 1
        if name in FUNCTIONS:
            self._refuse(f"{name!r} in a function", "a function takes one quantity, such as abs(w_x)")
        if name[:1].isdigit():
            self._refuse(f"the number {name}", "put it into the coefficient")
        if name in ("gimbal_0", "gimbal_rate_0"):
            self._refuse(f"{name!r} is no quantity", "gimbals are counted from 1")
        near = difflib.get_close_matches(name, [*allowed, *(FUNCTIONS if allowed == QUANTITIES else ())], n=1)
        if otherwise and not near:
            self._refuse(f"{name!r} here", otherwise)
        listed = f"the names are {', '.join([TIME, *RATES])}, R_xx to R_zz, gimbal_1, gimbal_rate_1 and torque_x"
        wrong = f"{name!r} is no quantity" if name else "it ends where a quantity is missing"
        return self._refuse(wrong, f"did you mean {near[0]}?" if near else listed)

    def _constant(self) -> Constant:
        token = self._take()
        if self._named and token in CONSTANTS:
            return token
        try:
            value = float(token)
        except ValueError:
            value = 0.0
        if not 0.0 < value < float("inf"):
            self._next -= 1
            self._refuse(f"{token or 'nothing'!r} in the place of a constant", "write a positive number, in Hz or s")
        return value

    @property
    def _ahead(self) -> str:
        return self._tokens[self._next][1] if self._next < len(self._tokens) else ""

    def _take(self) -> str:
        token = self._ahead
        self._next += 1
        return token

    def _expect(self, wanted: str) -> None:
        if self._ahead != wanted:
            self._refuse(f"{self._ahead!r}" if self._ahead else "it ends", f"write {wanted!r} there")
        self._take()

    def _refuse(self, wrong: str, advice: str) -> NoReturn:
        place = self._tokens[self._next][0] if self._next < len(self._tokens) else len(self._text)
        self._refuse_at(place, wrong, advice)

    def _refuse_at(self, place: int, wrong: str, advice: str) -> NoReturn:
        raise InputError(f"{self._text!r}, character {place + 1}: {wrong}; {advice}")
