"""Environments of their own for what would disturb the testbed's: made once, under build/."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

BUILD = Path(__file__).resolve().parents[1] / "build"
BASILISK = ("basilisk-venv", "bsk==2.12.1")
"""Name and requirement of Basilisk's."""


class UnavailableError(Exception):
    """Something to measure against cannot be installed; the message says what pip said."""


def environment(name: str, requirement: str) -> Path:
    """Return the interpreter of an environment that holds one requirement; make it where it is missing.

    Args:
        name: of the folder under build/.
        requirement: as pip takes it, pinned.

    Raises:
        UnavailableError: pip cannot install it.
    """
    folder = BUILD / name
    python, stamp = folder / "bin" / "python", folder / ".requirement"
    if stamp.is_file() and stamp.read_text(encoding="utf-8") == requirement:
        return python
    print(f"Installing {requirement} into {folder.relative_to(BUILD.parent)} (once) ...", flush=True)
    subprocess.run([sys.executable, "-m", "venv", str(folder)], check=True)
    install = [str(python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", requirement]
    done = subprocess.run(install, capture_output=True, text=True, check=False)
    if done.returncode:
        reason = (done.stderr.strip().splitlines() or ["no reason given"])[-1]
        raise UnavailableError(f"{requirement} cannot be installed: {reason}")
    stamp.write_text(requirement, encoding="utf-8")
    return python
