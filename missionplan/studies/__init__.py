"""Questions asked of a mission or of data: a folder a question, or one or two modules, the study named as its command.

Beside the folders lie `run` (arguments, workers, provenance of every study), `judgement`, `coverage`, `held_vehicle`,
which several ask, and the small studies: `validate` (of missions, and lazily of `data_sets`), `export` (the plan, of
`planned_phases`), `sweep_transition`, `schema` (JSON; `schema_sections` by pydantic) and `init` (the starter folder).
"""
