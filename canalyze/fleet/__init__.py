"""Parts of `canalyze fleet`; `commands/fleet.py` combines them. None of them knows the meaning of a frame.

stores.py    folders and object stores behind one interface: named objects
sources.py   the captures, their content hashes, and their download
manifest.py  the record of a finished capture; it decides if work is done; a verdict as JSON and back
task.py      one capture -> its manifest: the work of a worker, on any machine
run.py       all captures through an executor: a window of them, retries, quarantine
clusters.py  executors on Dask and Ray clusters
summary.py   all manifests as the reports of `canalyze/reports/`
"""
