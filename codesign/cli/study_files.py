"""The files that ``hwsw explore`` and ``hwsw report`` write of a study, as options of both."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from codesign.cli.options import command_line, force_option
from codesign.errors import printable

if TYPE_CHECKING:
    from codesign.exploration import Study
    from codesign.progress import Show

_FILE = click.Path(dir_okay=False, path_type=Path)
_OPTIONS = (
    click.option("--csv", "csv", type=_FILE, help="Write every computed point as CSV."),
    click.option(
        "--parquet",
        type=_FILE,
        help="Write every computed point as a Parquet file, for pandas, Polars and DuckDB.",
    ),
    click.option("--html", "page", type=_FILE, help="Write a self-contained HTML page."),
    click.option(
        "--certify",
        "certificate",
        type=_FILE,
        help="Write the certificate of the front: why each design off it is off it. hwsw verify-front checks it.",
    ),
    force_option,
)


@dataclass(frozen=True)
class StudyFiles:
    """Where to write what; None: nowhere."""

    csv: Path | None
    parquet: Path | None
    page: Path | None
    certificate: Path | None

    def check(self, inputs: Iterable[str | Path | None], store: tuple[str, Path] | None = None) -> None:
        """Check, before any work, that all can be written; see ``check_outputs``."""
        from codesign.cli.outputs import check_outputs
        from codesign.exploration.columns import libraries

        files = {
            "--csv": self.csv,
            "--parquet": self.parquet,
            "--html": self.page,
            "--certify": self.certificate,
        }
        check_outputs(files, inputs, store=store)
        if self.parquet is not None:
            libraries()

    def write(self, study: Study, show: Show) -> None:
        """Write those that were asked for."""
        from codesign.progress import doing
        from codesign.report import study_page, write_study_csv

        if self.csv is not None:
            write_study_csv(study, self.csv, show)
        if self.parquet is not None:
            study.to_parquet(self.parquet, show)
        if self.page is not None:
            study_page(study, self.page, command=command_line(), show=show)
        if self.certificate is not None:
            doing(show, "writing the certificate")
            study.certify(self.certificate)

    def name(self) -> None:
        """Print which were written."""
        names = {
            "csv": self.csv,
            "parquet": self.parquet,
            "page": self.page,
            "certificate": self.certificate,
        }
        for name, path in names.items():
            if path is not None:
                click.echo(f"{name}: {printable(str(path), None)}")


def study_file_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """The options of these files. The command gets ``files``, a ``StudyFiles``."""

    @wraps(command)
    def gathered(
        *,
        csv: Path | None,
        parquet: Path | None,
        page: Path | None,
        certificate: Path | None,
        **others: Any,
    ) -> Any:
        return command(files=StudyFiles(csv, parquet, page, certificate), **others)

    for option in reversed(_OPTIONS):
        gathered = option(gathered)
    return gathered
