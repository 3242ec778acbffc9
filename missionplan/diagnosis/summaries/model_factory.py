"""From a mission and summaries of dives to a model: the mission's first mooring at its means, bound to the tests."""

from missionplan.datasets.summaries import SummaryData
from missionplan.diagnosis.dives.model_factory import descent_builder, given_on_descent
from missionplan.diagnosis.summaries.model import SummaryForward, SummaryModel, as_log
from missionplan.mission import Mission


def summary_model(data: SummaryData, mission: Mission) -> SummaryModel:
    """Bind a mission's first mooring to summaries of dives.

    Raises
    ------
    InputError
        When the mission lacks what a descent needs.
    """
    logs = tuple(as_log(test) for test in data.tests)
    return SummaryModel(SummaryForward(descent_builder(mission), logs, tests=data.tests), given_on_descent(mission))
