"""The drive that nobody recorded is one that the map understands."""

from itertools import pairwise

import numpy as np

from runtime import navigate
from runtime.bench import synthetic
from runtime.core.types import Mount, Observation
from runtime.core.world import World
from runtime.robot.images.reading import decode_depth
from runtime.robot.session import TopicsConfig

TOPICS, MOUNT = TopicsConfig(), Mount(0.0, 0.0, 0.88, 0.0)


def test_messages_come_in_their_order_at_their_rates_and_can_be_decoded():
    messages = list(synthetic.drive(1.0, TOPICS, MOUNT))
    assert all(a.at_ns <= b.at_ns for a, b in pairwise(messages))
    by_topic = {topic: [m for m in messages if m.topic == topic] for topic in vars(TOPICS).values()}
    assert len(by_topic[TOPICS.odom]) == 1 / synthetic.ODOMETRY_S
    for topic in (TOPICS.color, TOPICS.depth, TOPICS.camera_info):
        assert len(by_topic[topic]) == round(1 / synthetic.FRAME_S)
    depth = decode_depth(by_topic[TOPICS.depth][0].payload, TOPICS.depth)
    assert depth.stamp_ns == by_topic[TOPICS.depth][0].at_ns
    assert 0.3 < np.median(depth.value) < 4.0


def test_the_room_is_mapped_with_its_furniture():
    cfg, world = navigate.NavigateConfig(), None
    for n in range(0, synthetic.ROUND_FRAMES, 8):
        pose = synthetic._pose(n * synthetic.FRAME_S)
        rgb, depth = synthetic._frame(pose, MOUNT)
        obs = Observation(n + 1, rgb, depth, pose, synthetic.LENS)
        world = world or World.begin("bed", ("bed",), (), pose, 0.18)
        navigate.survey(world, obs, MOUNT, cfg)
    assert world is not None
    frame = world.map.frame
    assert world.map.free[frame.cell(0.0, -1.5)]
    assert world.map.occupied[frame.cell(1.92, 0.0)]  # the table's side
    assert world.map.free.sum() * 0.05**2 > 8.0
