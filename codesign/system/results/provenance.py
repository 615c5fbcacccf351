"""The provenance of figures: version, digests of specs and map, seeds, and the date of what is written."""

from __future__ import annotations

from pydantic import Field

from codesign.ground.files import date_of_writing
from codesign.system.results.model import ResultModel
from codesign.version import __version__


class Provenance(ResultModel):
    """The inputs that made a result or a study. The same specs give the same, but for the date of what is written."""

    codesign: str = Field(default=__version__, description="version of hwsw")
    platform_digests: dict[str, str] = Field(
        default={}, description="SHA-256 of each platform by its name: of all that can change a result"
    )
    workload_digest: str | None = Field(
        default=None, description="SHA-256 of the workload: of all that can change a result"
    )
    calibration_digests: dict[str, str] = Field(
        default={}, description="SHA-256 of the calibration of each FPGA that names one, as PLATFORM.COMPONENT"
    )
    map_digest: str | None = Field(
        default=None, description="SHA-256 of the cells of the map; null without one, or where an axis moves it"
    )
    seeds: dict[str, int] = Field(
        default={}, description="each seed of the workload by the path of its key, but those that an axis moves"
    )
    date: str | None = Field(
        default=None, description="the day on which it was written, UTC, or that of SOURCE_DATE_EPOCH; else null"
    )

    def stamped(self) -> Provenance:
        """The same with the date of today, for what is written now."""
        return self.model_copy(update={"date": date_of_writing()})

    @property
    def constants(self) -> dict[str, str]:
        """The texts that identify it besides its platforms, for columns of CSV and for traces."""
        texts = {
            "codesign": self.codesign,
            "workload_digest": self.workload_digest,
            "map_digest": self.map_digest,
            "seeds": " ".join(f"{path}={seed}" for path, seed in self.seeds.items()),
            "date": self.date,
        }
        return {name: text for name, text in texts.items() if text}
