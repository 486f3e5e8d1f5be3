"""Parts of `canalyze fleet`; `commands/fleet.py` puts them together. None of them knows what a frame means.

stores.py    folders and object stores as one thing: places where objects have names
sources.py   which captures there are, what each is by its content, and how it gets here
manifest.py  what is known of a capture that was worked on; it is the truth on what is done
task.py      one capture -> its manifest: what a worker does, wherever it is
run.py       all captures through an executor: a window of them, retries, quarantine
dask.py      an executor on a Dask cluster
ray.py       an executor on a Ray cluster
stored.py    a verdict as JSON and back
summary.py   all manifests as the reports of `canalyze/reports/`
"""
