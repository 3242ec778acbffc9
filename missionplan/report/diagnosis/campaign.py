"""Report of `diagnose` with several data sets: what each showed, what they share, and each one's own answer."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from matplotlib.axes import Axes

from missionplan.effects import CATALOGUE
from missionplan.errors import InputError, Problem, shown
from missionplan.mission.includes import hash_of
from missionplan.report.diagnosis import findings
from missionplan.report.diagnosis.evidence import draw_ranking
from missionplan.report.diagnosis.kind_report import names, percent
from missionplan.report.diagnosis.page import answer as answer_of
from missionplan.report.diagnosis.page import is_open
from missionplan.report.diagnosis.page import page as page_of
from missionplan.report.diagnosis.plan import next_trial_section, next_trial_told
from missionplan.report.page import Block, Page, PageSection, Table, typed
from missionplan.report.wording import listed
from missionplan.results.entries import mapping, real
from missionplan.results.learned import Campaign
from missionplan.results.learned.evidence import Causes

LEFT = 0.05
"""Probability of none of the explanations from which it is told."""
COLUMNS = ("Data set", "Kind", "Verdict", "Causes", "Confirmed")
_PASSED_ON = (
    "An effect passes from one data set to the next through the mission: what one leaves of its parameters is what "
    "the next begins with. Dives, summaries of dives and the drag of the tank share the vehicle's effects; legs "
    "share theirs with other legs, and have none in common with dives. σ_v is that of the last record of legs. The "
    "order is that of the kinds (tank, dives, legs), then of the dates, then of the names. Another order could change "
    "what is claimed where an effect is weak in each record: one alone must show it (55 to 1) for it to be claimed."
)


def page(campaign: Campaign) -> Page:
    """Build the page of a campaign."""
    made, last = campaign.provenance, campaign.diagnoses[-1]
    folders = made.options["datasets"]
    paths = [made.file, *(folders if isinstance(folders, list) else [])]
    return Page(
        title=f"Diagnosis of {made.mission} with {len(campaign.diagnoses)} data sets",
        answer=answer(campaign),
        sentence=f"{answer(campaign)}{next_trial_told(last.next_trial, f'{len(campaign.diagnoses)}-{last.kind}')}",
        numbers=[("Data sets", str(len(campaign.diagnoses))), ("Effects learned of", str(len(campaign.informed_by)))],
        write=lambda: _sections(campaign),
        rerun=typed("diagnose", *paths, seed=made.seed),
        table=lambda: (COLUMNS, _rows(campaign)),
        plots={"ranking": ranking},
    )


def _sections(campaign: Campaign) -> list[PageSection]:
    rows = [[effect.replace("-", " "), ", ".join(names)] for effect, names in campaign.informed_by.items()]
    sections = [
        PageSection("What each data set showed", [Table(COLUMNS, _rows(campaign), text_columns=5)]),
        PageSection(
            "What they share",
            [_PASSED_ON, *([Table(["Effect", "Learned from"], rows, text_columns=2)] if rows else [])],
        ),
    ]
    for index, (diagnosis, name) in enumerate(zip(campaign.diagnoses, campaign.names, strict=True), start=1):
        figure = page_of(diagnosis).figure
        blocks: list[Block] = [answer_of(diagnosis)]
        if figure is not None:
            blocks.append(replace(figure, name=f"{figure.name}-{index}"))
        blocks.append(f"Everything about it is in the folder {index}-{diagnosis.kind}.")
        sections.append(PageSection(name, blocks))
    return [*sections, *next_trial_section(campaign.diagnoses[-1].next_trial, f"the folder {index}-{diagnosis.kind}")]


def answer(campaign: Campaign) -> str:
    """Say what the data sets showed: what was found with its size, as each diagnosis tells it, and what they share."""
    informed_by, last, many = campaign.informed_by, campaign.diagnoses[-1], len(campaign.diagnoses)
    named = list(zip(campaign.names, campaign.diagnoses, strict=True))
    names_of = {hash_of(diagnosis.learned_from): name for name, diagnosis in named}
    simulated = bool(campaign.provenance.options.get("plan") and last.learned_from)
    aged = findings.ageing_in_words(last.levels, names_of, simulated=simulated)
    suspects = [f"{name}: {words}" for name, diagnosis in named if (words := findings.suspects_in_words(diagnosis))]
    if not informed_by:
        return " ".join([*suspects, _without_cause(campaign), *aged])
    effects = ", ".join(effect.replace("-", " ") for effect in informed_by)
    shared = ", ".join(effect.replace("-", " ") for effect in campaign.shared)
    more = f" More than one of them bore on {shared}." if shared else " No two of them bore on the same effect."
    told = [(diagnosis.causes, words) for _, diagnosis in named if (words := findings.finding_in_words(diagnosis))]
    findings_by_words = dict.fromkeys(
        words for place, (causes, words) in enumerate(told) if not _again(causes, told[place + 1 :])
    )
    learned = mapping(mapping(campaign.extended.get("posterior")).get("summary"))
    gone = tuple(
        effect for effect in informed_by if effect not in learned and CATALOGUE[effect].belongs_to != "vehicle"
    )
    away = f"the extended mission carries all but {names(gone)}, which the mission of its own data set has"
    carries = f"{away}: it was learned elsewhere or at another time" if gone else "one extended mission carries it all"
    return " ".join(
        [
            *suspects,
            *findings_by_words,
            f"Together {many} data sets tell of {effects}; {carries}.{more}",
            *aged,
            *_doubts(learned),
        ]
    )


def _again(causes: Causes, later: Sequence[tuple[Causes, str]]) -> bool:
    """Whether a later data set tells of the same of the vehicle, which then has this one's say in it."""
    is_told = any({*causes} <= {*others} for others, _ in later)
    return is_told and all(CATALOGUE[cause].belongs_to == "vehicle" for cause in causes)


def _without_cause(campaign: Campaign) -> str:
    """Say of data sets of which none bore on an effect whether the mission's model is adequate."""
    pairs = zip(campaign.names, campaign.diagnoses, strict=True)
    left = [name for name, diagnosis in pairs if diagnosis.verdict == "unexplained"]
    least, many = min(diagnosis.nothing for diagnosis in campaign.diagnoses), len(campaign.diagnoses)
    if not any(diagnosis.learned_from for diagnosis in campaign.diagnoses):
        return "Nothing new: the mission has learned from all of these data, which count once."
    if left:
        return f"No cause of the catalogue explains what is left in {listed(left)}."
    if least < findings.LIKELIER:
        return findings.open_in_words("these data sets", "that one asks for a cause", least)
    both = "both" if many == 2 else f"all {many}"
    return f"The mission's model is adequate for {both} data sets: none asks for a cause."


def _doubts(learned: Mapping[str, object]) -> list[str]:
    """Say what the extended mission holds possible of which one holds."""
    shares = {name: real(mapping(summary).get("probability")) for name, summary in learned.items()}
    open_ = [f"{names((name,))} {percent(share)}" for name, share in shares.items() if LEFT < share < 1.0 - LEFT]
    return [f"Still in doubt: {', '.join(open_)}."] if open_ else []


def _rows(campaign: Campaign) -> list[list[str]]:
    rows = []
    for diagnosis, name in zip(campaign.diagnoses, campaign.names, strict=True):
        causes = [
            cause.replace("-", " ") + (" (changed)" if cause in diagnosis.changed else "") for cause in diagnosis.causes
        ]
        confirmed = [effect.replace("-", " ") for effect in diagnosis.borne_out]
        verdict = "nothing new" if not diagnosis.learned_from else "open" if is_open(diagnosis) else diagnosis.verdict
        rows.append([name, diagnosis.kind, verdict, ", ".join(causes) or "–", ", ".join(confirmed) or "–"])
    return rows


def ranking(axes: Axes, campaign: Campaign, dataset: int = 0) -> None:
    """Draw the evidence for each set of causes in one of the data sets, counted from 0."""
    if not 0 <= dataset < len(campaign.diagnoses):
        problem = f"given {shown(dataset)}, expected 0 to {len(campaign.diagnoses) - 1}"
        raise InputError([Problem(problem, key="dataset")])
    draw_ranking(axes, campaign.diagnoses[dataset])
    axes.set_title(campaign.names[dataset])
