"""Which stages belong to one step of the pipeline."""

GROUPS = {
    "upload": ["upload"],
    "boxes, levels": ["boxes", "levels"],
    "octree, hierarchy": ["count", "refine", "bottom_up", "top_down", "registration", "sort", "hierarchy"],
    # Results before commit 0c38451 have pair_tests, elementary and filter instead of pairs.
    "pairs, boxes of features, filter": ["pairs", "pair_tests", "elementary", "filter"],
    "narrow phase": ["narrow", "decide", "exact"],
    "order": ["order"],
    "download": ["download"],
    "other": [],
}
GROUP_OF = {stage: group for group, stages in GROUPS.items() for stage in stages}


def without_kind(stage):
    """"narrow_ee" to "narrow"."""
    return stage[:-3] if stage[-3:] in ("_vt", "_ee", "_tt") else stage


def grouped(stage_ms, concurrent_kinds=False):
    """Time of each group, from that of each stage. concurrent_kinds: the narrow phases of vertex-triangle and edge-edge
    pairs run at the same time, so that only the longer one counts."""
    out = dict.fromkeys(GROUPS, 0.0)
    for stage, ms in stage_ms.items():
        out[GROUP_OF.get(without_kind(stage), "other")] += ms
    if concurrent_kinds:
        out["narrow phase"] -= min(stage_ms.get("narrow_vt", 0), stage_ms.get("narrow_ee", 0))
    return out
