"""The JSON file of a solution, schema `orbsoc.solution/1`.

One object:

- `schema`: "orbsoc.solution/1"; `status`: a name of `orbsoc.Status`; `message`: what was verified, or why not;
- `x`, `y`, `z`, `s`: numbers; `objective`, `dual_objective`: numbers;
- `certificate`: {"primal_residual", "dual_residual", "gap", "radius"}, recomputed on the original data by the solver;
- `verification`: {"pres", "dres", "gap"} of `orbsoc.verify`, or null (not made, or the status is an infeasibility);
- `warm_start`: "none", "used" or "fell_back"; "none" where it is absent;
- `iterations`, `refinements`, `nnz_kkt`, `nnz_l`: integers; `setup_s`, `solve_s`: seconds of wall clock.

Numbers are written with as many digits as bring the same double back; those that JSON lacks are the strings "inf",
"-inf" and "nan". Unknown fields are errors.
"""

from __future__ import annotations

from typing import Any, get_args

from orbsoc.files.json_fields import Document, FieldError, Fields, encode_number, encode_numbers, shown

from .outcome import Certificate, Status, WarmStart
from .verify import Verification

SCHEMA = "orbsoc.solution/1"
_VECTORS = ("x", "y", "z", "s")
_NUMBERS = ("objective", "dual_objective", "setup_s", "solve_s")
_COUNTS = ("iterations", "refinements", "nnz_kkt", "nnz_l")
_CERTIFICATE = ("primal_residual", "dual_residual", "gap", "radius")
_VERIFICATION = ("pres", "dres", "gap")
_FIELDS = (
    "schema", "status", "message", *_VECTORS, *_NUMBERS, "certificate", "verification", *_COUNTS, "warm_start",
)  # fmt: skip


def encode_solution(solution: Any, verification: Verification | None = None) -> Document:
    """The document of an `orbsoc.Solution`, with the residuals of the independent verification if given."""
    return {
        "schema": SCHEMA,
        "status": solution.status.name,
        "message": solution.message,
        **{name: encode_number(getattr(solution, name)) for name in _NUMBERS},
        "certificate": {name: encode_number(getattr(solution.certificate, name)) for name in _CERTIFICATE},
        "verification": verification
        and {name: encode_number(getattr(verification, name)) for name in _VERIFICATION},
        **{name: getattr(solution, name) for name in _COUNTS},
        "warm_start": solution.warm_start,
        **{name: encode_numbers(getattr(solution, name)) for name in _VECTORS},
    }


def decode_solution(document: Any, prefix: str = "") -> dict[str, Any]:
    """The arguments of `orbsoc.Solution`; raises FieldError, with `prefix` before the field."""
    fields = Fields(document, prefix)
    fields.check_names(SCHEMA, _FIELDS)
    status = fields.text("status")
    if status not in Status.__members__:
        raise FieldError(
            fields.name("status"), f"is {shown(status)}; known are {', '.join(Status.__members__)}"
        )
    warm_start = fields.text("warm_start") if "warm_start" in fields.document else "none"
    if warm_start not in get_args(WarmStart):
        known = ", ".join(get_args(WarmStart))
        raise FieldError(fields.name("warm_start"), f"is {shown(warm_start)}; known are {known}")
    certificate = fields.inner("certificate")
    values: dict[str, Any] = {name: fields.numbers(name) for name in _VECTORS}
    values |= {name: fields.number(name) for name in _NUMBERS}
    values |= {name: fields.count(name) for name in _COUNTS}
    return values | {
        "status": Status[status],
        "message": fields.text("message"),
        "warm_start": warm_start,
        "certificate": Certificate(*(certificate.number(name) for name in _CERTIFICATE)),
    }
