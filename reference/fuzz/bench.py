"""The former name of `reference.fuzz.trial`; tests that earlier versions wrote import it."""

from __future__ import annotations

from reference.fuzz.trial import try_once

__all__ = ["try_once"]
