"""Which stages one reads as one step of the pipeline."""

GROUPS = {
    "upload": ["upload"],
    "boxes, levels": ["boxes", "levels"],
    "octree, hierarchy": ["count", "refine", "bottom_up", "top_down", "registration", "sort", "hierarchy"],
    # Results before commit 0c38451 have pair_tests, elementary and filter instead of pairs.
    "pairs, boxes of features, filter": ["pairs", "pair_tests", "elementary", "filter"],
    "narrow phase": ["narrow", "exact"],
    "order": ["order"],
    "download": ["download"],
    "other": [],
}
GROUP_OF = {stage: group for group, stages in GROUPS.items() for stage in stages}


def without_kind(stage):
    """"narrow_ee" to "narrow"."""
    return stage[:-3] if stage[-3:] in ("_vt", "_ee", "_tt") else stage


def grouped(stage_ms, kinds_beside=False):
    """Time of each group, from that of each stage. kinds_beside: of the two narrow phases of features, which then run
    at the same time, the longer one counts."""
    out = dict.fromkeys(GROUPS, 0.0)
    for stage, ms in stage_ms.items():
        out[GROUP_OF.get(without_kind(stage), "other")] += ms
    if kinds_beside:
        out["narrow phase"] -= min(stage_ms.get("narrow_vt", 0), stage_ms.get("narrow_ee", 0))
    return out
