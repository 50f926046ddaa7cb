"""Lets test files import each other as `tests.…`.

The root goes last on sys.path: `orbsoc` and `hw_model` stay those of the installed wheel.
"""

import signal
import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parent.parent))

# A shell that starts us in the background has SIGINT ignored, and so would every child: the tests of Ctrl-C
# need it as a terminal leaves it.
signal.signal(signal.SIGINT, signal.default_int_handler)
