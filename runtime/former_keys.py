"""Keys that the configuration once had: what they are called now, or which constant they became."""

RENAMED = {
    "consensus.rank": "research.consensus_rank",
    "consensus.mode": "research.consensus_mode",
    "consensus.fallback": "research.consensus_fallback",
    "consensus.weights": "research.consensus_weights",
    "consensus.detour_m": "research.consensus_detour_m",
    "consensus.veto": "research.consensus_veto",
    "consensus.seed": "research.consensus_seed",
    "experts.temperature": "research.experts_temperature",
    "experts.bar": "research.experts_bar",
    "experts.doubt": "research.experts_doubt",
    "panel.budget_in_lockstep": "research.budget_in_lockstep",
    "detector.source": "research.detector_source",
    "detector.labels": "research.detector_labels",
    "detector.memo_frames": "research.detector_memo_frames",
    "detector.second_looks": "research.second_looks",
    "models.second_look": "research.second_look",
    "models.vision_style": "research.vision_style",
    "models.context_tokens": "research.context_tokens",
    "models.score_file": "research.score_file",
    "cloud.spending_file": "research.cloud_spending_file",
    "cloud.images": "research.cloud_images",
    "cloud.image_tokens": "research.cloud_image_tokens",
    "cloud.reply_tokens": "research.cloud_reply_tokens",
    "cloud.local_share": "research.cloud_local_share",
    "cloud.on_disagreement": "research.cloud_on_disagreement",
    "control.mode": "research.control_mode",
}
"""Such a key goes on working, in files and in settings."""

GONE = {
    "runtime/core/mapping/grid.py": {
        "map.resolution_m": "RESOLUTION_M",
        "map.side_m": "SIDE_M",
        "map.stride": "STRIDE",
        "map.floor_below_m": "FLOOR_BELOW_M",
        "map.clear_above_m": "CLEAR_ABOVE_M",
        "map.hit": "HIT",
        "map.miss": "MISS",
        "map.hits_needed": "HITS_NEEDED",
        "map.occupied_at": "OCCUPIED_AT",
        "map.evidence_max": "EVIDENCE_MAX",
    },
    "runtime/core/mapping/frontiers.py": {
        "frontiers.min_cells": "MIN_CELLS",
        "frontiers.inherit_dilation_cells": "INHERIT_DILATION_CELLS",
        "frontiers.inherit_share": "INHERIT_SHARE",
        "frontiers.wall_gap_cells": "WALL_GAP_CELLS",
    },
    "runtime/core/mapping/coverage.py": {
        "coverage.near_m": "NEAR_M",
        "coverage.min_cells": "MIN_CELLS",
    },
    "runtime/core/mapping/keyframes.py": {
        "keyframes.kept": "KEYFRAMES_KEPT",
        "keyframes.moved_m": "MOVED_M",
        "keyframes.turned_rad": "TURNED_RAD",
        "keyframes.range_m": "RANGE_M",
        "keyframes.half_view_rad": "HALF_VIEW_RAD",
        "keyframes.blurred": "BLURRED",
    },
    "runtime/core/distances/planner.py": {
        "planner.margin_m": "MARGIN_M",
        "planner.comfort_m": "COMFORT_M",
        "planner.slowest": "SLOWEST",
        "planner.escape_m": "ESCAPE_M",
        "planner.dead_end_m": "DEAD_END_M",
        "planner.pocket_m2": "POCKET_M2",
        "planner.squeeze_m": "SQUEEZE_M",
        "planner.squeeze_slack_m": "SQUEEZE_SLACK_M",
        "planner.resort_slack_m": "RESORT_SLACK_M",
    },
    "runtime/core/voting/brief.py": {
        "brief.object_range_m": "OBJECT_RANGE_M",
        "brief.object_confidence": "OBJECT_CONFIDENCE",
        "brief.room_range_m": "ROOM_RANGE_M",
        "brief.room_weight_min": "ROOM_WEIGHT_MIN",
        "brief.doorway_m": "DOORWAY_M",
        "brief.jamb_m": "JAMB_M",
        "brief.unknown_depth_m": "UNKNOWN_DEPTH_M",
    },
    "runtime/core/voting/information_gain.py": {
        "gain.discount_per_m": "DISCOUNT_PER_M",
        "gain.keep_bonus": "KEEP_BONUS",
        "gain.room_bonus": "ROOM_BONUS",
        "gain.doorway_m": "DOORWAY_M",
    },
    "runtime/core/voting/likelihood_experts.py": {
        "experts.object_range_m": "OBJECT_RANGE_M",
        "experts.objects_heard": "OBJECTS_HEARD",
        "experts.prior_weight": "PRIOR_WEIGHT",
        "experts.view_scale": "VIEW_SCALE",
        "experts.unknown_weight": "UNKNOWN_WEIGHT",
        "experts.door_weight": "DOOR_WEIGHT",
    },
    "runtime/core/voting/rehearsal.py": {
        "speculation.slow_s": "SLOW_S",
        "speculation.every_s": "EVERY_S",
        "speculation.confidence": "CONFIDENCE_SLACK",
        "speculation.distance_m": "DISTANCE_SLACK_M",
        "speculation.rooms": "ROOMS_SLACK",
        "speculation.view": "VIEW_SLACK",
        "speculation.unknown_m2": "UNKNOWN_SLACK_M2",
    },
    "runtime/experts/panel.py": {"panel.reserve_s": "RESERVE_S"},
    "runtime/loops/realtime.py": {"realtime.feedback_s": "FEEDBACK_S"},
    "runtime/perception/loaded_models.py": {
        "models.text": "TEXT_MODEL",
        "models.reply_tokens": "REPLY_TOKENS",
    },
    "runtime/perception/detection.py": {"detector.min_score": "MIN_SCORE"},
    "runtime/perception/goal_words.py": {"goal.same_as_similarity": "SAME_AS_SIMILARITY"},
    "runtime/robot/streams.py": {
        "bus.pair_tolerance_s": "PAIR_TOLERANCE_S",
        "bus.odometry_gap_s": "ODOMETRY_GAP_S",
        "bus.sensor_timeout_s": "SENSOR_TIMEOUT_S",
    },
    "runtime/robot/session.py": {
        "bus.topics.action": "ACTION",
        "bus.topics.state": "STATE",
        "bus.topics.decision": "DECISION",
        "bus.topics.feedback": "FEEDBACK",
        "bus.topics.detections": "DETECTIONS",
        "bus.topics.goal": "GOAL",
        "bus.topics.cancel": "CANCEL",
        "bus.topics.status": "STATUS",
    },
}
"""By the file of the constant: a configuration that still has such a key is refused."""

FORMER = frozenset(RENAMED).union(*GONE.values())
"""All of them."""


def renamed(key: str) -> str | None:
    """What a former key is called now; None when it was not renamed."""
    return RENAMED.get(key)


def gone(key: str) -> str | None:
    """What became of a former key that cannot be set any more; None of others."""
    for file, constants in GONE.items():
        if key in constants:
            return f"cannot be set any more; it is the constant {constants[key]} in {file}"
    return None


def modern(setting: str) -> str:
    """A `KEY=VALUE` setting by the key's name of today."""
    key, equals, value = setting.partition("=")
    return RENAMED.get(key.strip(), key) + equals + value
