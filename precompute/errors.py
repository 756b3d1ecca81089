# SPDX-License-Identifier: GPL-3.0-or-later
"""Errors that a user can act on: each message is one sentence that says what is wrong and what to do."""


class DiffractionError(Exception):
    """Base of every error that is the input's fault; shown to the user as it is."""


class ScanError(DiffractionError):
    """A scan cannot be read, or does not hold a usable heightfield."""


class ParameterError(DiffractionError):
    """A parameter has a value that makes no sense or that the method cannot reach."""


class TableError(DiffractionError):
    """A spectral table is missing, damaged, or of another format version."""


class SizeLimitError(DiffractionError):
    """A result would be larger than the limit in force."""


class OutputError(DiffractionError):
    """A result cannot be written where the user wants it."""


class Cancelled(Exception):
    """The user stopped a running computation; nothing was written."""
