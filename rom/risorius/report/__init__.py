"""The report: what accuracy costs in time, measured here and now, as a table, a plot and a page.

Candidates (`candidates`) are run on held-out snapshots (`held_out`) and timed in turn (`measuring`); the results
(`results`) become files (`table`, `plot`, `page`) and sentences (`verdict`). Another method is compared by handing
`measure` one more `Candidate`.
"""
