# SPDX-License-Identifier: GPL-3.0-or-later
"""Damage to files: what a bad disk, a bad program or a bad person does.

All choices come from a `Chooser`: either Hypothesis makes each (thorough, and slow), or a random generator
whose seed Hypothesis drew.
"""

import random
import re
import struct

from hypothesis import strategies as st


class ByHypothesis:
    """Each choice is Hypothesis's."""

    def __init__(self, draw):
        self._draw = draw

    def whole(self, low, high):
        return self._draw(st.integers(low, high))

    def one_of(self, choices):
        return self._draw(st.sampled_from(choices))

    def octets(self, longest):
        return self._draw(st.binary(max_size=longest))


class ByRandom:
    """A thousand times as many choices in the same time."""

    def __init__(self, seed):
        self._random = random.Random(seed)
        self.whole, self.one_of = self._random.randint, self._random.choice

    def octets(self, longest):
        return self._random.randbytes(self.whole(0, longest))


_EXTREMES = [0, 1, 2, 0x7F, 0xFF, 0x7FFF, 0xFFFF, 2**31 - 1, 2**31, 2**32 - 1, 2**62, 2**63 - 1]
_FLOATS = [float("nan"), float("inf"), -float("inf"), 0.0, -1.0, 1e308, -1e308, 5e-324]
_NUMBERS = [
    b"0", b"-1", b"1", b"2", b"99999", b"2147483647", b"4294967296", b"99999999999999999999", b"1e400", b"1e308",
    b"-1e308", b"nan", b"inf", b"1e-320", b"0x10", b"", b"1_000", b"\xd9\xa3", b"1" * 5000, b"..", b"1.5",
]  # fmt: skip
_JUNK = [b"\0", b"\n", b"=", b":", b"\\", b"*", b"[", b"<", b"&", b"%s", b"../", b"\xff" * 8, b"\0" * 64, b"A" * 4096]


def damaged(choose, files, longest_head=8192):
    """One of ``files`` with one to five injuries."""
    data = bytearray(choose.one_of(files))
    for _ in range(choose.whole(1, 5)):
        if not data:
            break
        # Headers decide most, so half of all injuries go to the first bytes.
        reach = len(data) if choose.whole(0, 1) else min(len(data), longest_head)
        choose.one_of(_INJURIES)(choose, data, choose.whole(0, reach - 1))
    return bytes(data)


def _truncate(choose, data, at):
    del data[at:]


def _flip(choose, data, at):
    data[at] ^= 1 << choose.whole(0, 7)


def _byte(choose, data, at):
    data[at] = choose.whole(0, 255)


def _whole(choose, data, at):
    layout = choose.one_of(["<H", ">H", "<I", ">I", "<Q", ">Q"])
    value = choose.one_of(_EXTREMES) % 2 ** (8 * struct.calcsize(layout))
    data[at : at + struct.calcsize(layout)] = struct.pack(layout, value)


def _real(choose, data, at):
    layout = choose.one_of(["<d", ">d", "<f", ">f"])
    value = choose.one_of(_FLOATS)
    if layout[1] == "f" and abs(value) == 1e308:
        value /= 1e270
    data[at : at + struct.calcsize(layout)] = struct.pack(layout, value)


def _number(choose, data, at):
    """The first number in words behind ``at`` becomes a hostile one."""
    match = re.compile(rb"[-+]?\d+(\.\d*)?([eE][-+]?\d+)?").search(data, at, at + 4096)
    if match:
        data[match.start() : match.end()] = choose.one_of(_NUMBERS)


def _delete(choose, data, at):
    del data[at : at + choose.whole(1, 64)]


def _repeat(choose, data, at):
    data[at:at] = data[at : at + choose.whole(1, 512)] * choose.whole(1, 16)


def _insert(choose, data, at):
    data[at:at] = choose.one_of(_JUNK)


def _swap(choose, data, at):
    length, other = choose.whole(1, 64), choose.whole(0, len(data) - 1)
    data[at : at + length], data[other : other + length] = data[other : other + length], data[at : at + length]


def _random(choose, data, at):
    data[at:at] = choose.octets(64)


_INJURIES = (
    _truncate,
    _flip,
    _byte,
    _whole,
    _whole,
    _real,
    _number,
    _number,
    _delete,
    _repeat,
    _insert,
    _swap,
    _random,
)


def rejoined(choose, parts, join):
    """A file one of whose parts was damaged before they were joined, so that its checksums are right."""
    parts = list(parts)
    index = choose.whole(0, len(parts) - 1)
    parts[index] = damaged(choose, [parts[index]])
    return join(parts)


_STRANGE = [
    None, True, 0, -1, 1, 2, 3, 10**6, 2**31, 2**63, 10**40, 1e308, -1e308, 5e-324, 0.5, -0.0,
    float("nan"), float("inf"), -float("inf"), "", "1", "../../x", "\0", "x" * 10000, "none", [], [1, 2],
    {}, {"a": 1},
]  # fmt: skip


def changed(choose, value):
    """A JSON value with one to three of its leaves or branches replaced or removed."""
    for _ in range(choose.whole(1, 3)):
        value = _replace(choose, value)
    return value


def _replace(choose, value):
    if isinstance(value, dict) and value and choose.whole(0, 7):
        key = choose.one_of(sorted(value))
        if not choose.whole(0, 7):
            return {k: v for k, v in value.items() if k != key}
        return {**value, key: _replace(choose, value[key])}
    return choose.one_of(_STRANGE)
