"""A computer of one processing system (PS) and one programmable logic (PL), as tagged parameters.

A platform is a TOML file; `platforms/` holds those that ship, and presets.toml what they share.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Self

from pydantic import ValidationError, model_validator

from hw_model.errors import PlatformError, describe

from .data_file import Table, is_table, read, shipped
from .presets import preset, with_preset
from .sections import Area, Energy, Link, Pl, Ps, Resources, Runtime, Section

if TYPE_CHECKING:
    from .parameter import End


class Platform(Section):
    """A complete computer; `load_platform` makes one."""

    name: str
    description: str
    ps: Ps
    pl: Pl
    link: Link
    runtime: Runtime
    area: Area
    energy: Energy
    resources: Resources

    @model_validator(mode="after")
    def _enough_cores(self) -> Self:
        used, there = self.runtime.cores_used.value, self.ps.cores.value
        if used > there:
            raise ValueError(f"`runtime.cores_used` = {used}: this PS has {there}")
        if self.runtime.schedule.value == "overlapped" and used < 2:
            raise ValueError(
                '`runtime.cores_used` = 1: schedule "overlapped" needs 2, for one core controls the PL'
            )
        return self

    def corner(self, ps: End, fabric: End, build: End = "nominal") -> Platform:
        """This platform with three sets of bands at one end each.

        They are the PS; all that the PL brings with it; and the size of the problems' generation, apart from the PS
        because it slows run and baseline alike.
        """
        generation = self.ps.build_flops_per_nonzero.at(build, more_is_faster=False)
        cores = self.ps.at(ps).model_copy(update={"build_flops_per_nonzero": generation})
        fabric_side = {name: getattr(self, name).at(fabric) for name in ("pl", "link", "runtime")}
        return self.model_copy(update={"ps": cores, **fabric_side})

    def with_value(self, key: str, value: float | int | str) -> Platform:
        """A copy in which `key`, e.g. "pl.lanes" or "pl.latency_preset", is `value`, exactly (no band).

        Raises PlatformError for an unknown key or an impossible value.
        """
        return self.with_values({key: value})

    def with_values(self, settings: Mapping[str, float | int | str]) -> Platform:
        """A copy in which several parameters are set at once, as `with_value` sets one.

        A runtime preset comes first, whatever the order: "runtime.preset" = "linux" replaces the whole section.
        """
        raw = self.model_dump()
        if "runtime.preset" in settings:
            raw["runtime"] = preset("runtime", settings["runtime.preset"])
        allowed = [key for key, _ in self.parameters() if not key.startswith("pl.latencies.")]
        for key, value in settings.items():
            section, _, name = key.partition(".")
            if key == "pl.latency_preset":
                raw["pl"]["latency_preset"] = value
            elif key in allowed:
                was = raw[section][name]["value"]
                source = f"set for this run (was {was})"
                raw[section][name] = {"value": value, "tag": "assumed", "source": source}
            elif key != "runtime.preset":
                raise PlatformError(
                    f"`{key}` is not a parameter; allowed: {', '.join(allowed)}, pl.latency_preset, runtime.preset"
                )
        del raw["pl"]["latencies"]
        return _validated(raw, f"platform {self.name}")


def platform_names() -> list[str]:
    """Names of the platforms that ship."""
    return shipped("platforms")


def load_platform(name_or_path: str | Path) -> Platform:
    """A shipped platform by name ("zu9eg"), or one from a TOML file (a path, or a name ending in .toml).

    Raises PlatformError naming the key, its value and what is allowed.
    """
    raw, where = read("platform", "platforms", name_or_path, PlatformError)
    for section, name in (("runtime", "bare_metal"), ("area", "orbsoc_rtl"), ("energy", "nm28")):
        raw.setdefault(section, {"preset": name})
    for section in ("ps", "pl", "link", "runtime", "area", "energy"):
        given = raw.get(section)
        if is_table(given):
            try:
                raw[section] = with_preset(section, given)
            except PlatformError as error:
                raise PlatformError(f"{where}: {error}") from None
    return _validated(raw, where)


def _validated(raw: Table, where: str) -> Platform:
    """A platform from complete tables; the latencies come from presets.toml by `pl.latency_preset`."""
    try:
        pl = raw.get("pl")
        if is_table(pl) and "latency_preset" in pl:
            if "latencies" in pl:
                raise PlatformError("`pl.latencies` cannot be given; name a `pl.latency_preset`")
            raw = raw | {"pl": pl | {"latencies": preset("latency", pl["latency_preset"])}}
        return Platform.model_validate(raw)
    except ValidationError as error:
        raise PlatformError(f"{where}: {describe(error, Platform)}") from error
    except PlatformError as error:
        raise PlatformError(f"{where}: {error}") from None
