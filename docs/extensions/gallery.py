"""The gallery: scenarios planned while the site is built, each with its question, command, verdict, pictures and run time.

What a scenario gives is kept in `out/gallery` under a hash of its file and of the sources, and made anew when either changes.
"""

from __future__ import annotations

import hashlib
import json
import shutil
import tempfile
import time
from pathlib import Path
from typing import Any

from generated import write_changed
from sphinx.application import Sphinx
from sphinx.util import logging

ROOT = Path(__file__).resolve().parents[2]
KEPT = ROOT / "out" / "gallery"
TITLES = {
    "rec1": "Insertion into an orbit, as in paper 004",
    "deorbit_by_elements": "Bring a satellite down",
    "raise_two_burns": "Raise an orbit by two burns",
    "escape": "Leave the Earth, at the best moment",
    "station_vbar": "Approach a station along the V-bar",
    "geo_servicing": "Servicing in geostationary orbit",
    "paper000_free": "An approach that stays safe without an engine",
    "paper001_margin": "Fly around with margins for errors",
    "paper002_norms": "Launch from a platform, the cheapest rendezvous",
    "paper003_socp": "Phase for a meeting in J2 and drag",
    "phasing_two_tles": "Phasing between two catalogue entries",
}
"""Scenarios of the gallery, in its order."""
PAGE = """# {title}

{about}.

```sh
orbsoc plan scenarios/{name}.toml --device none
```

```text
{verdict}
```

{figures}

Planned in {seconds:.0f} s when this site was built. The scenario:

```toml
{scenario}
```
"""
FIGURE = """![{caption}]({name}/{file})

*{caption}*"""
INDEX = """# Gallery

Each of these was planned while the site was built. Click one for its question, its command and its answer.

:::::{{grid}} 1 2 2 3
:gutter: 3

{cards}
:::::

```{{toctree}}
:hidden:

{pages}
```
"""
CARD = """::::{{grid-item-card}} {title}
:link: {name}
:link-type: doc
:img-top: {picture}
::::"""
LOG = logging.getLogger(__name__)


def digest(scenario: Path) -> str:
    """Of the scenario and of every source that a plan depends on."""
    found = hashlib.sha256(scenario.read_bytes())
    for path in sorted((ROOT / "python").rglob("*.py")):
        found.update(path.read_bytes())
    return found.hexdigest()[:16]


def planned(name: str) -> Path:
    """The folder of a scenario's plan, planned now or kept: its pictures, and `done.json`."""
    import orbsoc

    scenario = ROOT / "scenarios" / f"{name}.toml"
    folder = KEPT / f"{name}-{digest(scenario)}"
    if not folder.exists():
        KEPT.mkdir(parents=True, exist_ok=True)
        made = Path(tempfile.mkdtemp(dir=KEPT))
        LOG.info("gallery: planning %s", name)
        begun = time.monotonic()
        run = orbsoc.plan(scenario, device="none")
        seconds = time.monotonic() - begun
        figures = [[figure.name, figure.caption] for figure in run.plan.figures(made) if not figure.appendix]
        kept = {"verdict": str(run.verdict), "seconds": seconds, "figures": figures}
        (made / "done.json").write_text(json.dumps(kept), encoding="utf-8")
        made.replace(folder)
    return folder


def write_pages(app: Sphinx) -> None:
    """A page a scenario in gallery/, and its index."""
    from orbsoc.guidance.shipped import shipped_scenarios

    target, cards = Path(app.srcdir) / "gallery", []
    for name, title in TITLES.items():
        folder, shipped = planned(name), shipped_scenarios()[name]
        kept = json.loads((folder / "done.json").read_text(encoding="utf-8"))
        (target / name).mkdir(parents=True, exist_ok=True)
        for file, _ in kept["figures"]:
            shutil.copy2(folder / file, target / name / file)
        figures = "\n\n".join(
            FIGURE.format(name=name, file=file, caption=text) for file, text in kept["figures"]
        )
        scenario = shipped.path.read_text(encoding="utf-8").rstrip()
        page = PAGE.format(
            title=title, about=shipped.about, name=name, scenario=scenario, **kept | {"figures": figures}
        )
        write_changed(target / f"{name}.md", page)
        cards.append(CARD.format(title=title, name=name, picture=f"{name}/{kept['figures'][0][0]}"))
    write_changed(target / "index.md", INDEX.format(cards="\n\n".join(cards), pages="\n".join(TITLES)))


def setup(app: Sphinx) -> dict[str, Any]:
    app.connect("builder-inited", write_pages)
    return {"parallel_read_safe": True}
