"""Pages of the scenario keys: the text that `orbsoc new` writes for each mission, so that the reference is the template itself."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from generated import write_changed
from sphinx.application import Sphinx

PAGE = """# {mission}

{meaning}

`orbsoc new {mission}` writes this file.

```toml
{text}
```
"""


def write_pages(app: Sphinx) -> None:
    """A page a mission in reference/keys."""
    from orbsoc.commands.new import scenario_text
    from orbsoc.guidance.shipped import shipped_scenarios
    from orbsoc.missions.registry import EXAMPLES, MISSIONS

    for name, mission in MISSIONS.items():
        text = scenario_text(name, shipped_scenarios()[EXAMPLES[name]], Path(f"my_{name}.toml"))
        meaning = (mission.Scenario.__doc__ or "").split("\n\n")[0]
        page = PAGE.format(mission=name, meaning=meaning, text=text.rstrip())
        write_changed(Path(app.srcdir) / "reference" / "keys" / f"{name}.md", page)


def setup(app: Sphinx) -> dict[str, Any]:
    app.connect("builder-inited", write_pages)
    return {"parallel_read_safe": True}
