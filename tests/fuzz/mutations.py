"""Good inputs, spoilt in the ways that readers of them fall over."""

import struct
from collections.abc import Sequence

from hypothesis import strategies as st

NUMBERS = (0, 1, 2, 127, 128, 255, 256, 65535, 2**16, 2**30, 2**31 - 1, 2**31, 2**32 - 1, 2**63)
REALS = (0.0, -1.0, 1e-300, 5e-324, 1e9, 1e300, float("inf"), float("-inf"), float("nan"))
WORDS = (
    b"[", b"{", b"]", b"}", b'"', b"'", b"\\", b"\0", b"\n", b"=", b",", b".", b"null", b"NaN",
    b"1e999", b"-1", b"9" * 400, b"[" * 200, b"{" * 200, b"a." * 300, b"\xff\xfe", b"\\ud800",
    b"true", b"<!ENTITY", b"<", b"&", b"../../", b"/dev/zero", b"%s%n", b"0x", b"\x7f" * 9,
)  # fmt: skip


Spoiling = tuple[int | bytes, list[tuple[str, float, bytes]]]
"""Which good input, by its number, or bytes of no meaning; and up to six changes."""


def spoilt(seeds: Sequence[bytes], spoiling: Spoiling) -> bytes:
    whole, changes = spoiling
    data = seeds[whole % len(seeds)] if isinstance(whole, int) else whole
    for kind, share, value in changes:
        at = int(share * len(data))
        if kind == "cut":
            data = data[:at]
        elif kind == "put":
            data = data[:at] + value + data[at + len(value) :]
        elif kind == "aligned":  # as CDR and most headers are
            at -= at % 4
            data = data[:at] + value + data[at + len(value) :]
        elif kind == "insert":
            data = data[:at] + value + data[at:]
        elif kind == "drop":
            data = data[:at] + data[at + len(value) :]
        else:  # twice
            data = data[:at] + data[at : at + 64] + data[at:]
    return data


_VALUES = (
    st.binary(min_size=1, max_size=8)
    | st.sampled_from([struct.pack("<Q", n) for n in NUMBERS])
    | st.sampled_from([struct.pack("<I", n) for n in NUMBERS if n < 2**32])
    | st.sampled_from([struct.pack(">I", n) for n in NUMBERS if n < 2**32])
    | st.sampled_from([struct.pack("<d", x) for x in REALS])
    | st.sampled_from([struct.pack("<f", x) for x in REALS if not 1e38 < abs(x) < 1e301])
    | st.sampled_from(WORDS)
)
_CHANGES = st.tuples(
    st.sampled_from(("cut", "put", "put", "aligned", "aligned", "insert", "drop", "twice")),
    st.floats(0.0, 1.0),
    _VALUES,
)
SPOILINGS: st.SearchStrategy[Spoiling] = st.tuples(
    st.integers(0, 63) | st.binary(max_size=200), st.lists(_CHANGES, max_size=6)
)
