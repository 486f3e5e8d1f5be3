"""Parts of `canalyze check`; `commands/check.py` puts them together. None of them knows what a frame means.

examination.py  one capture: its findings, counted by kind
workers.py      several captures at once, in processes
policy.py       what a finding counts: severities, ignored ones, the threshold
baseline.py     what was known before
verdict.py      what came of it, as `canalyze/reports/` gets it
"""
