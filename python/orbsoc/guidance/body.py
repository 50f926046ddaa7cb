"""The body that a scenario's orbits are about: the Earth where it says nothing."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from orbsoc.orbit import EARTH, MARS, MOON, ConstantsSet

NAMED = {"earth": EARTH, "moon": MOON, "mars": MARS}


class CentralBody(BaseModel):
    """The body that the orbits are about: by its name, or its own gravitational parameter, radius and oblateness."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)

    name: Literal["earth", "moon", "mars", "own"] = "earth"
    mu_m3_s2: float | None = Field(default=None, gt=1e3, le=1e21, description="m³/s²; of name = own")
    radius_m: float | None = Field(default=None, gt=1e2, le=1e9, description="equatorial, of name = own")
    j2: float | None = Field(default=None, ge=-0.1, le=0.1, description="of name = own; 0")

    @model_validator(mode="after")
    def _one_of_two(self) -> Self:
        for key in ("mu_m3_s2", "radius_m", "j2"):
            given = getattr(self, key) is not None
            if given and self.name != "own":
                raise PydanticCustomError("body", f"{key} changes nothing; name must be 'own'")
            if not given and self.name == "own" and key != "j2":
                raise PydanticCustomError(
                    "body", f"{key} is missing; name = 'own' needs mu_m3_s2 and radius_m"
                )
        return self

    @property
    def constants(self) -> ConstantsSet:
        """The figures of the body."""
        if self.mu_m3_s2 is None or self.radius_m is None:
            return NAMED[self.name]
        return ConstantsSet("own", self.mu_m3_s2, self.radius_m, "the scenario", self.j2 or 0.0, "UNKNOWN")


def central_body(document: Mapping[str, Any]) -> CentralBody:
    """The body of a scenario that is not checked yet; the Earth where its table will be refused."""
    try:
        return CentralBody(**document.get("body", {}))
    except (TypeError, ValueError):
        return CentralBody()
