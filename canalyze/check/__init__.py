"""Parts of `canalyze check`; `commands/check.py` puts them together. None of them knows what a frame means.

examination.py  captures, several at once, in processes: their findings, counted by kind; options, the policy in force
policy.py       what a finding counts: severities, ignored ones, the threshold
baseline.py     what was known before
verdict.py      what came of it, as `canalyze/reports/` gets it
"""
