# SPDX-License-Identifier: GPL-3.0-or-later
"""The chapters of docs/evaluation.md. Each has ``run(pictures) -> {block: text}`` and writes its pictures."""
