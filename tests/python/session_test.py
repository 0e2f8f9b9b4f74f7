#!/usr/bin/env python3
"""A whole session from Python: stubs made from the protos, a real semmapd, images without any library.

Usage: session_test.py --stubs DIR --server FILE --config FILE
"""

import argparse
import hashlib
import os
import queue
import signal
import subprocess
import sys
import tempfile
import unittest

import google
import grpc

import wall_scene

OPTIONS = argparse.Namespace()
DEADLINE_S = 60


def load_stubs(directory):
    """Makes the generated modules importable. google.rpc lies beside Debian's google.protobuf, in another place."""
    sys.path.insert(0, directory)
    google.__path__.append(os.path.join(directory, "google"))
    global camera_pb2, frame_pb2, map_service_pb2, map_service_pb2_grpc, operation_pb2, operation_pb2_grpc
    global session_pb2, session_service_pb2_grpc, status_pb2, error_details_pb2
    from google.rpc import error_details_pb2, status_pb2
    from semmap.v1 import (camera_pb2, frame_pb2, map_service_pb2, map_service_pb2_grpc, operation_pb2,
                           operation_pb2_grpc, session_pb2, session_service_pb2_grpc)


class Server:
    """A semmapd of its own with its database in a temporary directory."""

    def __init__(self):
        self.directory = tempfile.TemporaryDirectory()
        with open(os.path.join(self.directory.name, "log"), "wb") as log:
            self.process = subprocess.Popen(
                [OPTIONS.server, "--config", OPTIONS.config, "--data", self.directory.name, "--listen", "127.0.0.1:0"],
                stdout=subprocess.PIPE, stderr=log, text=True)
        self.address = self.process.stdout.readline().strip().removeprefix("listening on ")

    def stop(self):
        """Ends it as an operator would; its exit code."""
        self.process.send_signal(signal.SIGTERM)
        code = self.process.wait(timeout=DEADLINE_S)
        self.process.stdout.close()
        self.directory.cleanup()
        return code


def raw(pixels):
    return frame_pb2.Image(encoding=frame_pb2.IMAGE_ENCODING_RAW_GRAY8, data=pixels, width=wall_scene.WIDTH,
                           height=wall_scene.HEIGHT)


def stereo_rig():
    camera = camera_pb2.CameraIntrinsics(
        width=wall_scene.WIDTH, height=wall_scene.HEIGHT, fx=wall_scene.FOCAL_PX, fy=wall_scene.FOCAL_PX,
        cx=wall_scene.WIDTH / 2, cy=wall_scene.HEIGHT / 2, distortion_model=camera_pb2.DISTORTION_MODEL_NONE)
    return camera_pb2.CameraRig(sensor=camera_pb2.SENSOR_TYPE_STEREO, camera=camera, frames_per_second=10,
                                baseline_m=wall_scene.BASELINE_M)


def frame(index):
    return frame_pb2.Frame(sequence=index + 1, timestamp_ns=index * 100_000_000, image=raw(wall_scene.image(index)),
                           right=raw(wall_scene.image(index, right=True)), class_mask=raw(wall_scene.class_mask()))


class Drive:
    """Streams the scene, as credit allows, and keeps what the server says."""

    def __init__(self, stub, map_name):
        self.outgoing = queue.Queue()
        self.estimates, self.acknowledged, self.started, self.summary = [], 0, None, None
        hello = session_pb2.SessionHello(vehicle_id="python", mode=session_pb2.SESSION_MODE_MAP, map=map_name,
                                         rig=stereo_rig())
        self.outgoing.put(session_pb2.StreamFramesRequest(hello=hello))
        self.next_frame = 0
        for response in stub.StreamFrames(iter(self.outgoing.get, None), timeout=4 * DEADLINE_S):
            self.take(response)
        self.outgoing.put(None)

    def take(self, response):
        kind = response.WhichOneof("response")
        if kind == "started":
            self.started = response.started
            self.send(response.started.credit)
        elif kind == "credit":
            self.send(response.credit.frames)
        elif kind == "estimate":
            self.estimates.append(response.estimate)
        elif kind == "acknowledgement":
            self.acknowledged = response.acknowledgement.sequence
        elif kind == "summary":
            self.summary = response.summary

    def send(self, credit):
        for _ in range(credit):
            if self.next_frame < wall_scene.FRAMES:
                self.outgoing.put(session_pb2.StreamFramesRequest(frame=frame(self.next_frame)))
            elif self.next_frame == wall_scene.FRAMES:
                self.outgoing.put(session_pb2.StreamFramesRequest(end=session_pb2.SessionEnd()))
            self.next_frame += 1


def reason_of(error):
    """The reason of google.rpc.ErrorInfo in a failed call."""
    details = dict(error.trailing_metadata())["grpc-status-details-bin"]
    info = error_details_pb2.ErrorInfo()
    status_pb2.Status.FromString(details).details[0].Unpack(info)
    return info.reason


class SessionTest(unittest.TestCase):
    """The tests share one drive and only read what it left."""

    @classmethod
    def setUpClass(cls):
        cls.server = Server()
        cls.channel = grpc.insecure_channel(cls.server.address)
        cls.maps = map_service_pb2_grpc.MapServiceStub(cls.channel)
        cls.operations = operation_pb2_grpc.OperationServiceStub(cls.channel)
        cls.drive = Drive(session_service_pb2_grpc.SessionServiceStub(cls.channel), "maps/walls")

    @classmethod
    def tearDownClass(cls):
        cls.channel.close()
        code = cls.server.stop()
        assert code == 0, f"semmapd ended with {code}"

    def test_every_frame_has_its_pose(self):
        self.assertEqual([e.sequence for e in self.drive.estimates], list(range(1, wall_scene.FRAMES + 1)))
        for estimate in self.drive.estimates:
            self.assertEqual(estimate.state, session_pb2.TRACKING_STATE_TRACKING)
            position = estimate.map_from_camera.translation
            self.assertAlmostEqual(position.x, wall_scene.STEP_M * (estimate.sequence - 1), delta=0.05)
            self.assertAlmostEqual(position.y, 0, delta=0.05)
            self.assertAlmostEqual(position.z, 0, delta=0.05)

    def test_the_session_ends_well(self):
        self.assertEqual(self.drive.acknowledged, wall_scene.FRAMES)
        session = self.drive.summary.session
        self.assertEqual(session.name, self.drive.started.session)
        self.assertEqual(session.state, session_pb2.SESSION_STATE_FINISHED)
        self.assertEqual(session.statistics.frames_tracked, wall_scene.FRAMES)

    def test_points_lie_on_the_walls_and_have_their_classes(self):
        request = map_service_pb2.QueryMapPointsRequest(map="maps/walls")
        request.filter.min_observations = 2
        points = 0
        for response in self.maps.QueryMapPoints(request, timeout=DEADLINE_S):
            columns = response.points
            for i, semantic_class in enumerate(columns.semantic_classes):
                depth = wall_scene.NEAR_M if semantic_class == wall_scene.NEAR_CLASS else wall_scene.FAR_M
                self.assertAlmostEqual(columns.positions[3 * i + 2], depth, delta=0.5)
                self.assertGreater(columns.class_confidences[i], 0.5)
            points += len(columns.ids)
        self.assertGreater(points, 200)

    def test_queries_by_class(self):
        request = map_service_pb2.QueryMapPointsRequest(map="maps/walls", limit=10)
        request.filter.semantic_classes.append(wall_scene.FAR_CLASS)
        for response in self.maps.QueryMapPoints(request, timeout=DEADLINE_S):
            self.assertEqual(set(response.points.semantic_classes), {wall_scene.FAR_CLASS})
            self.assertLessEqual(len(response.points.ids), 10)

    def test_the_trajectory_is_stored(self):
        request = map_service_pb2.GetTrajectoryRequest(map="maps/walls")
        sequences = []
        for response in self.maps.GetTrajectory(request, timeout=DEADLINE_S):
            self.assertEqual(response.session, self.drive.started.session)
            sequences += response.trajectory.sequences
        self.assertEqual(sequences, list(range(1, wall_scene.FRAMES + 1)))

    def test_the_summary_counts(self):
        summary = self.maps.GetMapSummary(map_service_pb2.GetMapSummaryRequest(name="maps/walls"), timeout=DEADLINE_S)
        self.assertEqual(summary.frame_count, wall_scene.FRAMES)
        self.assertEqual(summary.session_count, 1)
        self.assertAlmostEqual(summary.trajectory_length_m, wall_scene.STEP_M * (wall_scene.FRAMES - 1), delta=0.2)
        self.assertEqual({c.display_name for c in summary.classes if c.points > 20}, {"Building", "Wall"})

    def test_an_export_arrives_whole(self):
        operation = self.maps.ExportMap(
            map_service_pb2.ExportMapRequest(name="maps/walls", format=map_service_pb2.MAP_FILE_FORMAT_CSV),
            timeout=DEADLINE_S)
        while not operation.done:
            operation = self.operations.WaitOperation(operation_pb2.WaitOperationRequest(name=operation.name),
                                                      timeout=2 * DEADLINE_S)
        exported = map_service_pb2.ExportMapResponse()
        self.assertTrue(operation.response.Unpack(exported), operation.error)
        request = map_service_pb2.ReadArtifactRequest(name=exported.artifact)
        file = b"".join(r.chunk for r in self.maps.ReadArtifact(request, timeout=DEADLINE_S))
        self.assertEqual(len(file), exported.size_bytes)
        self.assertEqual(hashlib.sha256(file).digest(), exported.sha256)
        self.assertTrue(file.startswith(b"id,x,y,z,class,class_name,"))

    def test_failures_carry_their_reasons(self):
        with self.assertRaises(grpc.RpcError) as raised:
            self.maps.GetMap(map_service_pb2.GetMapRequest(name="maps/nowhere"), timeout=DEADLINE_S)
        self.assertEqual(raised.exception.code(), grpc.StatusCode.NOT_FOUND)
        self.assertEqual(reason_of(raised.exception), "MAP_NOT_FOUND")


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    for option in ("--stubs", "--server", "--config"):
        parser.add_argument(option, required=True)
    parser.parse_args(namespace=OPTIONS)
    load_stubs(OPTIONS.stubs)
    unittest.main(argv=[sys.argv[0]], verbosity=2)
