"""Everything that a study found, as its report and its results file take it."""

from dataclasses import dataclass

from octant.em.reader.comparison import ResponseDifference
from octant.reader_design.experiments.choice.thesis_claims import Claim, thesis_claims
from octant.reader_design.experiments.choice.thesis_setup import ThesisSetup
from octant.reader_design.experiments.missions.stage import RoomMission
from octant.reader_design.experiments.study.shortlist import DrivenDesign
from octant.reader_design.experiments.study.verdict import Verdict, study_verdict
from octant.reader_design.setting.evaluation import Cell
from octant.reader_design.setting.ranking import Candidate, Choice
from octant.reader_design.setting.setting import Setting
from octant.reader_design.showing.pages import ReportSection


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyContent:
    """Everything that a study's report is made of.

    Attributes
    ----------
    setting : Study, room and sampling.
    cells, candidates, choice : All cells, failed ones too; the scored ones; their ranking.
    driven : The designs that drove the missions, the chosen one first.
    notes : What the user should know: tags that were moved, validity of models.
    approximations : How far the approximate responses are off for the chosen reader ([dB],).
    as_built : What tolerances do to the chosen reader ([mm], [deg]); None: no tolerances.
    thesis : What the thesis' designs among the cells receive in its set-up [W]; None: not asked.
    study_toml, quick, seconds : The resolved study; whether a quick look; time since start [s].
    """

    setting: Setting
    cells: tuple[Cell, ...]
    candidates: tuple[Candidate, ...]
    choice: Choice
    driven: tuple[DrivenDesign, ...]
    notes: tuple[str, ...]
    study_toml: str
    quick: bool
    seconds: float
    approximations: tuple[ResponseDifference, ...] = ()
    as_built: ReportSection | None = None
    thesis: ThesisSetup | None = None

    @property
    def chosen(self) -> Candidate:
        """The chosen design with its scores ([rad], [dB], [W],)."""
        return self.candidates[self.choice.chosen]

    @property
    def missions(self) -> tuple[RoomMission, ...]:
        """Missions of the chosen design, one for each room ([s], [m], [rad], [W])."""
        return self.driven[0].missions

    @property
    def claims(self) -> tuple[Claim, ...]:
        """Claims of the thesis that the sweep tests, numbers with their units."""
        if self.thesis is None:
            return ()
        return thesis_claims(self.cells, self.candidates, self.choice, self.thesis)

    @property
    def verdict(self) -> Verdict:
        """What the study came to: one sentence, judged numbers, and what to try ([deg], [%])."""
        mission = self.setting.study.mission
        return study_verdict(
            self.chosen,
            self.chosen_cell.design.antennas,
            self.missions,
            0 if mission is None else len(mission.tags),
        )

    @property
    def chosen_cell(self) -> Cell:
        """The chosen design's cell, RSS in [W]."""
        return next(cell for cell in self.cells if cell.key == self.chosen.key)
