"""Lets test files import each other as `tests.…`.

The root goes last on sys.path: `orbsoc` and `hw_model` stay those of the installed wheel.
"""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parent.parent))
