"""Keys that the configuration once had: what they are called now, or which constant they became."""

RENAMED = {
    "map.clear_above_m": "robot.height_m",
    "cloud.timeout_s": "research.cloud_timeout_s",
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
    "models.detector": "models.detectors",
}
"""Such a key goes on working, in files and in settings."""

LISTED = frozenset({"models.detector"})
"""Of these, what was one value is a list of it now."""

REMOVED = {
    "models.detector_kind": "the contract is read from the file",
    "models.detector_classes": "name the classes when the file is taken in, with `rfnav models "
    "import FILE --as NAME --classes FILE`",
    "bus.topics.detections": "publish labels on rfnav/labels",
}
"""What has no successor, and what to do instead."""

GONE = {
    "runtime/core/mapping/grid.py": {
        "map.resolution_m": "RESOLUTION_M",
        "map.side_m": "SIDE_M",
        "map.stride": "STRIDE",
        "map.floor_below_m": "FLOOR_BELOW_M",
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
        "planner.pocket_m2": "POCKET_M2",
        "planner.squeeze_m": "SQUEEZE_M",
        "planner.squeeze_slack_m": "SQUEEZE_SLACK_M",
        "planner.resort_slack_m": "RESORT_SLACK_M",
    },
    "runtime/core/distances/terrain.py": {
        "planner.margin_m": "MARGIN_M",
        "planner.comfort_m": "COMFORT_M",
        "planner.slowest": "SLOWEST",
        "planner.escape_m": "ESCAPE_M",
        "planner.dead_end_m": "DEAD_END_M",
    },
    "runtime/core/objects/depth_segments.py": {
        "semantics.core_share": "CORE_SHARE",
        "semantics.near_quantile": "NEAR_QUANTILE",
        "semantics.edge_m": "EDGE_M",
        "semantics.edge_share": "EDGE_SHARE",
        "semantics.floor_m": "FLOOR_M",
        "semantics.within_share": "WITHIN_SHARE",
        "semantics.span_share": "SPAN_SHARE",
        "semantics.cluster_m": "CLUSTER_M",
        "semantics.before_share": "BEFORE_SHARE",
        "semantics.before_m": "BEFORE_M",
        "semantics.min_points": "MIN_POINTS",
    },
    "runtime/core/objects/semantic_map.py": {
        "semantics.stride": "STRIDE",
        "semantics.miss_range_m": "MISS_RANGE_M",
        "semantics.room_range_m": "ROOM_CREDIT_M",
    },
    "runtime/core/objects/footprints.py": {
        "semantics.stray": "STRAY",
    },
    "runtime/core/objects/instances.py": {
        "semantics.associate_m": "ASSOCIATE_M",
        "semantics.other_name_m": "OTHER_NAME_M",
        "semantics.same_cosine": "SAME_COSINE",
        "semantics.same_size_share": "SAME_SIZE_SHARE",
        "semantics.same_height_share": "SAME_HEIGHT_SHARE",
        "target.rival_cosine": "RIVAL_COSINE",
        "target.rival_size": "RIVAL_SIZE",
        "semantics.neutral_score": "NEUTRAL_SCORE",
        "semantics.max_step": "MAX_STEP",
        "semantics.miss_step": "MISS_STEP",
        "semantics.repeat_weight": "REPEAT_WEIGHT",
        "semantics.cut_weight": "CUT_WEIGHT",
        "semantics.new_view_m": "NEW_VIEW_M",
        "semantics.new_view_rad": "NEW_VIEW_RAD",
        "semantics.nearer": "NEARER",
        "semantics.farther": "FARTHER",
        "semantics.log_odds_max": "LOG_ODDS_MAX",
    },
    "runtime/core/objects/recall.py": {
        "semantics.recall_log_odds": "RECALL_LOG_ODDS",
    },
    "runtime/core/objects/verdict.py": {
        "target.inspect_log_odds": "INSPECT_LOG_ODDS",
        "target.confirm_log_odds": "CONFIRM_LOG_ODDS",
        "target.confirm_views": "CONFIRM_VIEWS",
        "target.second_side_rad": "SECOND_SIDE_RAD",
        "target.second_nearer": "SECOND_NEARER",
        "target.rejection_log_odds": "REJECTION_LOG_ODDS",
        "target.seen_m": "SEEN_M",
    },
    "runtime/core/objects/standpoints.py": {
        "target.stop_m": "STOP_M",
        "target.low_m": "LOW_M",
        "target.reach_m": "REACH_M",
        "target.view_cone_rad": "VIEW_CONE_RAD",
    },
    "runtime/core/objects/candidates.py": {
        "target.keep_log_odds": "KEEP_LOG_ODDS",
        "target.detour_m": "DETOUR_M",
        "target.keep_m": "KEEP_M",
        "target.rival_share": "RIVAL_SHARE",
        "target.apart_confidence": "APART_CONFIDENCE",
        "target.apart_size": "APART_SIZE",
    },
    "runtime/core/motion/courses.py": {
        "control.margin_m": "MARGIN_M",
    },
    "runtime/core/motion/discrete_policy.py": {
        "control.forward_m": "FORWARD_M",
        "control.turn_rad": "TURN_RAD",
        "control.turn_cost_m": "TURN_COST_M",
        "control.samples": "SAMPLES",
    },
    "runtime/core/motion/velocity_policy.py": {
        "control.hold_s": "HOLD_S",
        "control.side_accel_mps2": "SIDE_ACCEL_MPS2",
        "control.tight_share": "TIGHT_SHARE",
        "control.comfort_m": "FULL_SPEED_M",
        "control.look_ahead_m": "LOOK_AHEAD_M",
        "control.turn_gain": "TURN_GAIN",
        "control.turn_on_spot_rad": "TURN_ON_SPOT_RAD",
        "control.facing_rad": "FACING_RAD",
        "control.creep_mps": "CREEP_MPS",
    },
    "runtime/core/world.py": {
        "explore.first_looks": "FIRST_LOOKS",
    },
    "runtime/core/local_policy.py": {
        "explore.decide_every": "DECIDE_EVERY",
        "explore.decide_every_s": "DECIDE_EVERY_S",
        "explore.patience": "GIVE_UP_AFTER",
        "explore.patience_s": "GIVE_UP_AFTER_S",
        "explore.blocked_m": "BLOCKED_M",
        "explore.blocked_s": "BLOCKED_S",
    },
    "runtime/core/exploration.py": {
        "explore.arrived_m": "ARRIVED_M",
        "explore.seen_range_m": "SEEN_RANGE_M",
    },
    "runtime/core/progress.py": {
        "explore.returns": "RETURNS",
        "explore.blind_share": "BLIND_SHARE",
    },
    "runtime/core/outlook.py": {
        "explore.worth_m2": "WORTH_M2",
    },
    "runtime/navigate.py": {
        "explore.weak_log_odds": "WEAK_LOG_ODDS",
        "explore.faint_log_odds": "FAINT_LOG_ODDS",
    },
    "runtime/core/objects/catalogue.py": {"brief.object_confidence": "OBJECT_CONFIDENCE"},
    "runtime/core/voting/brief.py": {
        "brief.object_range_m": "OBJECT_RANGE_M",
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
        "experts.object_range_m": "OBJECT_DECAY_M",
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
    "runtime/loops/feedback.py": {"realtime.feedback_s": "FEEDBACK_S"},
    "runtime/perception/loaded_models.py": {
        "models.text": "TEXT_MODEL",
        "models.reply_tokens": "REPLY_TOKENS",
    },
    "runtime/perception/detection.py": {"detector.min_score": "MIN_SCORE"},
    "runtime/perception/goal_words.py": {"goal.same_as_similarity": "SAME_AS_SIMILARITY"},
    "runtime/robot/streams.py": {
        "bus.pair_tolerance_s": "PAIR_TOLERANCE_S",
        "bus.sensor_timeout_s": "SENSOR_TIMEOUT_S",
    },
    "runtime/robot/odometry_stream.py": {"bus.odometry_gap_s": "GAP_S"},
    "runtime/robot/session.py": {
        "bus.topics.action": "ACTION",
        "bus.topics.state": "STATE",
        "bus.topics.decision": "DECISION",
        "bus.topics.feedback": "FEEDBACK",
        "bus.topics.goal": "GOAL",
        "bus.topics.cancel": "CANCEL",
        "bus.topics.status": "STATUS",
    },
}
"""By the file of the constant: a configuration that still has such a key is refused."""

FORMER = frozenset(RENAMED).union(REMOVED, *GONE.values())
"""All of them."""


def renamed(key: str) -> str | None:
    """What a former key is called now; None when it was not renamed."""
    return RENAMED.get(key)


def gone(key: str) -> str | None:
    """What became of a former key that cannot be set any more; None of others."""
    for file, constants in GONE.items():
        if key in constants:
            return f"cannot be set any more; it is the constant {constants[key]} in {file}"
    return f"cannot be set any more; {REMOVED[key]}" if key in REMOVED else None


def modern(setting: str) -> str:
    """A `KEY=VALUE` setting by the key's name of today."""
    key, equals, value = setting.partition("=")
    if key.strip() in LISTED:
        value = f"[{value}]"
    return RENAMED.get(key.strip(), key) + equals + value
