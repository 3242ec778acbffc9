"""The kinds of data in the report of a diagnosis: `kinds` lists them, `kind_report` says what each has."""
