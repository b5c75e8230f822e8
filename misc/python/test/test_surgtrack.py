#!/usr/bin/env python

from __future__ import print_function

import copy
import os
import pickle
import shutil
import subprocess
import sys
import tempfile

import numpy as np
import cv2 as cv

from tests_common import NewOpenCVTests

st = cv.surgtrack


def rigid(rotation_vector, translation):
    T = np.eye(4)
    T[:3, :3] = cv.Rodrigues(np.float64(rotation_vector))[0]
    T[:3, 3] = translation
    return T


class surgtrack_test(NewOpenCVTests):

    def test_an_error_has_its_own_text(self):
        camera = st.CameraModel(np.array([[800, 0, 360], [0, 800, 288], [0, 0, 1.]]), np.zeros(5), (720, 576))
        tracker = st.ToolTracker.create(camera)
        calls = [lambda: tracker.addTool(st.ToolModel.needleDriver(), np.eye(4)[:3]),
                 lambda: tracker.update(np.zeros((576, 720, 3), np.uint8), 0., [np.zeros(7)])]
        texts = []
        for call in (calls[0], calls[1], calls[0]):
            with self.assertRaises(cv.error) as raised:
                call()
            texts.append(raised.exception.err)
        self.assertEqual(texts[0], texts[2])
        self.assertIn('nominal_T_base', texts[0])
        self.assertIn('addTool', texts[1])

    def setUp(self):
        super(surgtrack_test, self).setUp()
        self.folder = tempfile.mkdtemp()
        self.K = np.array([[818., 0, 360], [0, 822, 288], [0, 0, 1]])
        self.camera = st.CameraModel(self.K, np.zeros(5), (720, 576))
        self.model = st.ToolModel.needleDriver()
        self.joints = np.array([0.0, 0.0, 0.12, 0.2, 0.3, -0.2, 0.5])

    def tearDown(self):
        shutil.rmtree(self.folder)
        super(surgtrack_test, self).tearDown()

    def path(self, name):
        return os.path.join(self.folder, name)

    def scene(self, **options):
        params = st.SyntheticScene.Params()
        params.imageSize = (360, 288)
        params.frames = 6
        for name, value in options.items():
            setattr(params, name, value)
        return st.SyntheticScene.create(None, params)

    # A pose of the arm's base from which the built-in tool is in the middle of the view, 0.1 m away.
    def camera_T_base(self):
        tool = self.model.endEffectorPose(self.joints)
        T = rigid([0, 2.2, 0], [0, 0, 0])
        T[:3, 3] = [0, 0, 0.1] - T[:3, :3].dot(tool[:3, 3])
        return T

    def test_camera_projects_and_unprojects(self):
        camera = st.CameraModel(self.K, np.array([-0.2, 0.06, 0.001, 0.001, 0]), (720, 576))
        self.assertTrue(camera.hasDistortion())
        self.assertFalse(self.camera.hasDistortion())
        self.assertEqual(tuple(camera.imageSize()), (720, 576))
        np.testing.assert_array_equal(camera.cameraMatrix(), self.K)
        self.assertEqual(camera.distCoeffs().ravel()[0], -0.2)
        points = np.array([[0.01, 0.02, 0.1], [-0.02, 0.01, 0.12]])
        projected = camera.projectPoints(points).reshape(-1, 2)
        expected = cv.projectPoints(points, np.zeros(3), np.zeros(3), self.K, camera.distCoeffs()[:, :5])[0].reshape(-1, 2)
        np.testing.assert_allclose(projected, expected, atol=1e-9)   # the same formula
        rays = camera.unprojectPoints(projected).reshape(-1, 2)
        np.testing.assert_allclose(rays, points[:, :2] / points[:, 2:], atol=1e-6)   # inverted by iteration

    def test_errors_are_exceptions(self):
        with self.assertRaises((cv.error, SystemError)):   # what Python makes of an exception in a constructor
            st.CameraModel(np.eye(2), np.zeros(5), (720, 576))
        with self.assertRaises(cv.error):
            st.ToolModel.load(self.path('missing.yaml'))
        with self.assertRaises(cv.error):
            st.Sequence.load(self.path('missing'))
        with self.assertRaises(cv.error):
            st.PoseWriter.create(self.path('missing/poses.csv'))
        with self.assertRaises(cv.error):
            self.model.endEffectorPose(np.full(7, np.nan))

    def test_tool_model(self):
        self.assertEqual(list(self.model.coordinateNames()), ['q1', 'q2', 'q3', 'q4', 'q5', 'q6', 'jaw'])
        self.assertEqual(self.model.coordinateIndex('jaw'), 6)
        self.assertEqual(self.model.coordinateIndex('none'), -1)
        self.assertEqual(len(self.model.keypointNames()), 14)
        self.assertGreater(len(self.model.linkNames()), 3)
        vertices, triangles = self.model.getMesh(0)
        self.assertEqual((vertices.shape[1], triangles.shape[1]), (3, 3))
        self.assertLess(triangles.max(), len(vertices))
        points, jacobian = self.model.keypointPositions(self.joints)
        self.assertEqual((points.shape, jacobian.shape), ((14, 3), (42, 7)))
        step = 1e-6
        for c in range(7):
            moved = self.joints.copy()
            moved[c] += step
            difference = (self.model.keypointPositions(moved)[0] - points).ravel() / step
            np.testing.assert_allclose(jacobian[:, c], difference, atol=1e-6)   # forward difference: step * curvature / 2

    def test_links_and_their_meshes_are_in_place(self):
        poses = self.model.linkPoses(self.joints)
        names = self.model.linkNames()
        self.assertEqual((poses.shape, poses.dtype), ((len(names), 4, 4), np.float64))
        np.testing.assert_array_equal(poses[:, 3], np.tile([0, 0, 0, 1], (len(names), 1)))
        np.testing.assert_allclose(poses[:, :3, :3] @ poses[:, :3, :3].transpose(0, 2, 1), np.tile(np.eye(3), (len(names), 1, 1)), atol=1e-12)   # rounding
        meshes = [self.model.linkMesh(link) for link in range(len(names))]
        self.assertTrue(-1 in meshes and max(meshes) > 0)
        # The nearest point of the meshes, placed by hand, is as far away as the drawing says.
        camera_T_link = self.camera_T_base() @ poses
        nearest = min((camera_T_link[link] @ np.c_[self.model.getMesh(mesh)[0], np.ones(len(self.model.getMesh(mesh)[0]))].T)[2].min()
                      for link, mesh in enumerate(meshes) if mesh >= 0)
        depth = st.MeshRenderer.createSoftware().renderTool(self.model, self.joints, self.camera_T_base(), self.camera)[0]
        self.assertLess(nearest, depth[depth > 0].min() + 1e-6)   # float
        for bad in (-1, len(names)):
            with self.assertRaises(cv.error):
                self.model.linkMesh(bad)
        with self.assertRaises(cv.error):
            self.model.linkPoses(np.zeros(3))
        np.testing.assert_array_equal(self.model.endEffectorFromLinks(poses), self.model.endEffectorPose(self.joints))
        tip = self.model.endEffectorLink()
        jacobian = self.model.pointJacobian(poses, tip, self.model.endEffectorPose(self.joints)[:3, 3])
        step = 1e-6
        for c in range(7):
            if self.model.coordinateNames()[c] == 'jaw':
                continue   # the end effector may be on a link that the jaw does not move
            moved = self.joints.copy()
            moved[c] += step
            difference = (self.model.endEffectorPose(moved) - self.model.endEffectorPose(self.joints))[:3, 3] / step
            np.testing.assert_allclose(jacobian[:, c], difference, atol=1e-6)   # forward difference: step * curvature / 2
        with self.assertRaises(cv.error):
            self.model.pointJacobian(poses, len(names), (0, 0, 0))
        with self.assertRaises(cv.error):
            self.model.endEffectorFromLinks(poses[:2])

    def test_everything_public_is_documented(self):
        for owner in [st] + [value for value in vars(st).values() if isinstance(value, type)]:
            for name, value in vars(owner).items():
                if name.startswith('_') or not callable(value) or isinstance(value, type) or '_' in name and owner is st and name.split('_')[0] in vars(st):
                    continue
                signature, _, text = (value.__doc__ or '').partition('\n')
                if name != 'create':   # of these the signature says it, or the class
                    self.assertGreater(len(text), 10, '%s.%s: %s' % (owner.__name__, name, signature))

    def test_everything_public_is_reachable(self):
        folder = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..')
        if not os.path.exists(os.path.join(folder, 'unreachable.py')):
            self.skipTest('these tests lie elsewhere than the headers')
        sys.path.insert(0, folder)
        try:
            import unreachable
        finally:
            sys.path.remove(folder)
        self.assertEqual(unreachable.unreachable(), [])
        headers = self.path('opencv2')   # what is not wrapped is told from what is, and from what is private
        os.makedirs(os.path.join(headers, 'surgtrack'))
        with open(os.path.join(headers, 'surgtrack.hpp'), 'w') as f:
            f.write('#include "opencv2/surgtrack/stage.hpp"\n')
        open(os.path.join(headers, 'surgtrack', 'lab.hpp'), 'w').close()
        with open(os.path.join(headers, 'surgtrack', 'stage.hpp'), 'w') as f:
            f.write('namespace cv { namespace surgtrack { struct CV_EXPORTS_W_SIMPLE Found { CV_PROP int part; double value; };\n'
                    'class CV_EXPORTS_W Stage { int hidden(); public: CV_WRAP virtual int run(int a = f(1)) = 0; virtual void stop() { if (a) { b(); } }\n'
                    'virtual const int& last() const = 0; CV_WRAP_AS(last) int copyLast() const; protected: virtual void help() = 0; };\n'
                    'CV_EXPORTS void use(int a); CV_EXPORTS_W void reuse(int a, const Matx44d& T = g()); /* CV_EXPORTS void none(); */ class CV_EXPORTS Other { int a; }; }}\n')
        missing = {line.partition(':')[0] for line in unreachable.unreachable(headers) if 'cannot reach it;' in line}
        self.assertEqual(missing, {'Found.value', 'Stage.stop', 'use', 'Other'})
        self.assertTrue(any(line.startswith('reuse: OpenCV cannot leave out') for line in unreachable.unreachable(headers)))

    def test_tool_model_saves_and_loads(self):
        self.model.save(self.path('tool.yaml'))
        loaded = st.ToolModel.load(self.path('tool.yaml'))
        self.assertEqual(loaded.name(), self.model.name())
        np.testing.assert_allclose(loaded.endEffectorPose(self.joints), self.model.endEffectorPose(self.joints), atol=1e-12)   # rounding

    def test_tool_gets_keypoints_and_a_sheet(self):
        self.model.save(self.path('tool.yaml'))
        with open(self.path('tool.yaml')) as file:
            text = file.read()
        with open(self.path('bare.yaml'), 'w') as file:
            file.write(text[:text.index('keypoints:')] + 'keypoints: []\n')
        model = st.loadTool(self.path('bare.yaml'))
        scores = model.keypointScores()
        self.assertGreaterEqual(len(scores), 24)
        self.assertTrue(all(0 < score <= 1 for score in scores))
        self.assertEqual(st.checkTool(model), ())
        self.assertEqual(st.chooseKeypoints(st.ToolModel.load(self.path('bare.yaml')), 24).keypointNames(), model.keypointNames())
        sheet = st.drawToolSheet(model)
        self.assertEqual((sheet.dtype, sheet.shape[2]), (np.uint8, 3))
        self.assertEqual(model.jointLimits().shape, (7, 2))

    def test_mesh_renderer_draws_the_tool(self):
        renderer = st.MeshRenderer.createSoftware()
        depth, ids, shading = renderer.renderTool(self.model, self.joints, self.camera_T_base(), self.camera)
        self.assertEqual((depth.dtype, ids.dtype, shading.dtype), (np.float32, np.uint8, np.uint8))
        self.assertEqual(depth.shape, (576, 720))
        np.testing.assert_array_equal(depth > 0, ids > 0)
        self.assertGreater((ids > 0).mean(), 0.01)
        self.assertTrue(hasattr(st.MeshRenderer, 'createVTK'))

    def test_mesh_renderer_draws_a_triangle(self):
        renderer = st.MeshRenderer.createSoftware()
        corners = np.array([[-0.02, -0.015, 0], [0.02, -0.015, 0], [0, 0.02, 0]])
        mesh = st.Mesh(corners, np.tile([0., 0, -1], (3, 1)), [(0, 1, 2)])
        np.testing.assert_allclose(mesh.vertices, corners, atol=1e-9)   # float
        np.testing.assert_array_equal(mesh.triangles, [[0, 1, 2]])
        handle = renderer.addMesh(mesh)
        T = rigid([0.4, -0.3, 0.1], [0.005, -0.002, 0.1])
        window = (100, 50, 500, 480)
        drawing = renderer.render(self.camera, window, [st.MeshInstance(handle, 7, T)])
        self.assertEqual(drawing.window, window)
        self.assertEqual((drawing.depth.shape, drawing.depth.dtype), ((480, 500), np.float32))
        # The rays of all pixels, against the plane of the triangle and its three edges.
        v, u = np.mgrid[50:530, 100:600]
        rays = np.dstack([(u - 360) / 818., (v - 288) / 822., np.ones(u.shape)])
        n, p = T[:3, 2], T[:3, 3]
        z = n.dot(p) / rays.dot(n)
        on_plane = (rays * z[:, :, None] - p).dot(T[:3, :3])[:, :, :2]
        inside = np.full(u.shape, np.inf)   # distance from the nearest edge [m], negative outside
        for i in range(3):
            a, b = corners[i, :2], corners[(i + 1) % 3, :2]
            d = (b - a) / np.linalg.norm(b - a)
            inside = np.minimum(inside, (on_plane - a).dot([-d[1], d[0]]))
        pixel = 0.1 / 818.
        self.assertGreater(np.count_nonzero(inside > pixel), 30000)
        np.testing.assert_allclose(drawing.depth[inside > pixel], z[inside > pixel], atol=2e-6)   # float maps, vertices to 1/256 pixel
        self.assertTrue((drawing.ids[inside > pixel] == 7).all())
        self.assertTrue((drawing.depth[inside < -pixel] == 0).all() and (drawing.ids[inside < -pixel] == 0).all())
        shade = 255 * np.abs(rays.dot(n)) / np.linalg.norm(rays, axis=2)
        np.testing.assert_allclose(drawing.shading[inside > pixel], shade[inside > pixel], atol=2.5)   # eight bits
        # A part of it alone, the nearer of two, and what is no mesh.
        part = renderer.render(self.camera, window, [st.MeshInstance(handle, 7, T)], [(360, 270, 16, 16)])
        np.testing.assert_array_equal(part.depth[220:236, 260:276], drawing.depth[220:236, 260:276])
        both = renderer.render(self.camera, window, [st.MeshInstance(handle, 7, T), st.MeshInstance(handle, 9, rigid([0, 0, 0], [0, 0, -0.02]) @ T)])
        self.assertEqual(both.ids[238, 260], 9)
        for bad in (st.MeshInstance(handle + 1, 7, T), st.MeshInstance(handle, 0, T), st.MeshInstance()):
            with self.assertRaises(cv.error):
                renderer.render(self.camera, window, [bad])
        for bad in (st.Mesh(), st.Mesh(corners, [], [(0, 1, 2)]), st.Mesh(corners, np.tile([0., 0, -1], (3, 1)), [(0, 1, 3)])):
            with self.assertRaises(cv.error):
                renderer.addMesh(bad)

    def test_meshes_come_from_files_and_tools(self):
        self.model.save(self.path('tool.yaml'))
        meshes = self.model.meshes()
        self.assertEqual(len(meshes), max(self.model.linkMesh(link) for link in range(len(self.model.linkNames()))) + 1)
        self.assertEqual(meshes[0].normals.shape, meshes[0].vertices.shape)
        files = sorted(os.path.join(self.path('meshes'), name) for name in os.listdir(self.path('meshes')))
        loaded = [st.loadMesh(name) for name in files]
        self.assertEqual(sorted(len(m.triangles) for m in loaded), sorted(len(m.triangles) for m in meshes))
        moved = st.loadMesh(files[0], 2., rigid([0, 0, np.pi / 2], [0, 0, 1]))
        x, y, z = 2 * loaded[0].vertices.T
        np.testing.assert_allclose(np.sort(moved.vertices, axis=0), np.sort(np.c_[-y, x, z + 1], axis=0), atol=1e-6)   # float
        with self.assertRaises(cv.error):
            st.loadMesh(self.path('missing.ply'))

    def test_tools_hide_each_other(self):
        params = st.PartTemplateRenderer.Params()
        params.wholeTool = True
        renderer = st.PartTemplateRenderer.create(None, params)
        self.assertEqual([renderer.addTool(self.model), renderer.addTool(self.model)], [0, 1])
        self.assertEqual(renderer.model(1).name(), self.model.name())
        poses = self.model.linkPoses(self.joints)
        far = st.ToolView(self.camera_T_base(), poses)
        np.testing.assert_array_equal(far.linkPoses(), poses)
        near = st.ToolView(rigid([0, 0, 0], [0.006, 0, -0.03]) @ self.camera_T_base(), list(poses))
        alone = renderer.render(self.camera, [far, st.ToolView()], 0)
        drawing = renderer.rendering()
        kept = drawing.ids.copy()
        hidden = renderer.render(self.camera, [far, near], 0)
        self.assertGreater(len(alone), len(hidden))
        self.assertEqual({t.tool for t in renderer.render(self.camera, [far, near], 1)}, {1})
        self.assertEqual(set(np.unique(renderer.rendering().ids)), {0, 1, 2})
        np.testing.assert_array_equal(drawing.ids, kept)   # a copy
        larger = {t.part: t.viewPoint for t in renderer.render(self.camera, [far, st.ToolView()], 0, 1.2)}
        smaller = [larger[t.part][2] < t.viewPoint[2] for t in alone if t.part in larger]
        self.assertTrue(smaller and all(smaller))   # drawn larger is drawn nearer
        with self.assertRaises(cv.error):
            renderer.render(self.camera, [far], 0)

    def test_part_templates_are_found_where_they_were_drawn(self):
        renderer = st.PartTemplateRenderer.create(st.MeshRenderer.createSoftware(), st.PartTemplateRenderer.Params())
        renderer.addTool(self.model)
        templates = renderer.renderTool(self.camera, self.camera_T_base(), self.joints)
        self.assertGreaterEqual(len(templates), 4)
        for t in templates:
            features = t.getFeatures()
            self.assertEqual(features.shape[1], 3)
            self.assertGreaterEqual(len(features), st.PartTemplateRenderer.Params().minFeatures)
            self.assertTrue(0 <= features[:, 2].min() and features[:, 2].max() < 8)

        shading = st.MeshRenderer.createSoftware().renderTool(self.model, self.joints, self.camera_T_base(), self.camera)[2]
        matcher = st.QGOMatcher.create(st.QGOMatcher.Params())
        matcher.setImage(shading)
        matches = matcher.match(templates, [])
        best = {}
        for m in matches:
            best.setdefault(m.part, m)   # sorted by falling similarity
        for t in templates:
            self.assertGreater(best[t.part].similarity, 0.8)
            np.testing.assert_allclose(best[t.part].imagePoint, t.imagePoint, atol=3)   # half the spreading, rounded up
        x, y = t.anchor
        similarity = matcher.similarityMap(t, (x - 5, y - 4, 11, 9))
        self.assertEqual((similarity.shape, similarity.dtype), ((9, 11), np.uint16))

        verifier = st.GeometricContextVerifier.create(st.GeometricContextVerifier.Params())
        found, inliers = verifier.verify(matches)
        self.assertTrue(found)
        self.assertEqual(len(set(m.part for m in inliers)), len(inliers))
        found, inliers = verifier.verify(matches[:2])
        self.assertFalse(found)
        self.assertEqual(len(inliers), 0)

    def test_contours_are_found_where_the_tool_is(self):
        params = st.ToolContour.Params()
        params.spacing, params.maxPoints = 4., 150
        points = st.ToolContour.create(self.model, params).sampleTool(self.camera, self.camera_T_base(), self.joints)
        self.assertTrue(50 < len(points) <= 150)
        ids = st.MeshRenderer.createSoftware().renderTool(self.model, self.joints, self.camera_T_base(), self.camera)[1]
        for p in points:
            self.assertFalse(p.found)
            self.assertFalse(p.crease)
            self.assertTrue(0 <= p.link < len(self.model.linkNames()))
            self.assertAlmostEqual(np.linalg.norm(p.normal), 1, places=9)   # rounding
            x, y = np.round(np.subtract(p.imagePoint, np.multiply(1.5, p.normal))).astype(int)
            self.assertGreater(ids[max(y - 1, 0):y + 2, max(x - 1, 0):x + 2].max(), 0)   # inwards there is the tool
        # Grey in front of black: the outline lies half a pixel outside of the last pixel drawn.
        image = np.where(ids > 0, 160, 40).astype(np.uint8)
        search = st.ContourSearch()
        search.halfWindow, search.minStrength = 5., 10.
        found, matched = st.matchContour(image, points, search)
        self.assertEqual(len(matched), len(points))
        self.assertEqual(found, sum(p.found for p in matched))
        self.assertGreater(found, 0.7 * len(points))   # but for corners, and edges that have another one beside them
        offsets = np.array([p.offset for p in matched if p.found])
        self.assertLess(abs(np.median(offsets)), 0.3)   # the drawing has no pixels that are half covered
        self.assertTrue(all(p.deviation > 0 and p.strength >= 10 for p in matched if p.found))
        with self.assertRaises(cv.error):
            st.matchContour(np.zeros((10, 10), np.float32), points, search)
        search.halfWindow = 0.
        with self.assertRaises(cv.error):
            st.matchContour(image, points, search)

    def test_outline_of_a_drawing_is_moved_to_another_view(self):
        contour, poses = st.ToolContour.create(self.model), self.model.linkPoses(self.joints)
        view = st.ToolView(self.camera_T_base(), poses)
        drawing = st.Rendering()   # filled by hand
        drawing.window = (0, 0, 720, 576)
        drawing.depth, ids, drawing.shading = st.MeshRenderer.createSoftware().renderTool(self.model, self.joints, self.camera_T_base(), self.camera)
        drawing.ids = np.where(ids > 0, 3, 0).astype(np.uint8)
        points = contour.sample(self.camera, view, drawing, 3)
        expected = contour.sampleTool(self.camera, self.camera_T_base(), self.joints)
        np.testing.assert_array_equal([p.imagePoint for p in points], [p.imagePoint for p in expected])
        self.assertEqual(len(contour.sample(self.camera, view, drawing, 4)), 0)
        points = st.placeContour(self.camera, view, points)
        np.testing.assert_allclose([p.imagePoint for p in points], [p.imagePoint for p in expected], atol=0.01)   # meshes are in float, the shaft is long
        moved = st.placeContour(self.camera, st.ToolView(rigid([0, 0, 0], [0.001, 0, 0]) @ self.camera_T_base(), poses), points)
        self.assertEqual(len(moved), len(points))
        for p, q in zip(points, moved):
            z = (self.camera_T_base() @ poses[p.link] @ np.append(p.linkPoint, 1))[2]
            np.testing.assert_allclose(np.subtract(q.imagePoint, p.imagePoint), [0.818 / z, 0], atol=1e-9)   # rounding
        own = moved[0]   # an edge from elsewhere
        own.found, own.offset, own.deviation = True, 1.5, 0.3
        self.assertEqual((own.found, own.offset, own.deviation), (True, 1.5, 0.3))
        with self.assertRaises(cv.error):
            st.placeContour(self.camera, st.ToolView(), points)

    def test_offset_deviations(self):
        np.testing.assert_array_equal(np.ravel(self.model.offsetDeviations()), [0, 0, 0, 0.03, 0.03, 0.03, 0.03])   # the wrist and the jaw

    def test_gradient_orientations(self):
        image = np.zeros((40, 60), np.uint8)
        image[:, 30:] = 200   # a horizontal gradient
        orientations = st.quantizeOrientations(image)
        self.assertEqual(set(np.unique(orientations)), {0, 1})
        spread = st.spreadOrientations(orientations, size=5)
        self.assertGreater((spread > 0).sum(), (orientations > 0).sum())
        self.assertEqual(st.orientationResponse(spread, 0).max(), 4)
        self.assertEqual(st.orientationResponse(spread, 1).max(), 1)
        self.assertEqual(st.orientationResponse(spread, 4).max(), 0)
        np.testing.assert_array_equal(st.quantizeOrientationsInWindow(image, (20, 4, 25, 30)), orientations[4:34, 20:45])

    def test_filter_finds_the_correction(self):
        true_correction = rigid([0.02, -0.03, 0.01], [0.003, -0.002, 0.004])
        rng = np.random.RandomState(3)
        points = np.array([0, 0, 0.1]) + rng.uniform(-0.02, 0.02, (10, 3))
        state = st.stateFromCorrection(true_correction)
        np.testing.assert_allclose(st.correctionFromState(state), true_correction, atol=1e-12)   # rounding
        image_points, jacobian = st.projectKeypoints(self.camera, state, points)
        self.assertEqual(jacobian.shape, (20, 6))
        image_points = image_points.reshape(-1, 2)

        found, correction = st.solveEPnP(self.camera, points, image_points)
        self.assertTrue(found)
        np.testing.assert_allclose(correction, true_correction, atol=1e-5)   # exact points; EPnP is linear

        ekf = st.ToolPoseEKF.create(self.camera, st.ToolPoseEKF.Params())
        ekf.reset(np.eye(4))
        before = np.trace(ekf.covariance())
        for _ in range(30):
            ekf.predict()
            updated, used = ekf.correct(points, image_points)
        self.assertTrue(updated)
        self.assertEqual(used.size, 10)
        self.assertLess(np.trace(ekf.covariance()), before)
        self.assertLess(np.abs(ekf.correction() - true_correction).max(), 2e-3)   # far below the 0.03 and 4 mm it starts from
        self.assertEqual(ekf.state().size, 6)
        self.assertEqual(ekf.imageCovariance((0, 0, 0.1)).shape, (2, 2))
        self.assertEqual(ekf.poseCovariance((0, 0, 0.1)).shape, (6, 6))
        self.assertGreaterEqual(ekf.nis(), 0)

    # METHOD_FULL for one tool and one eye, as short as it gets: each stage called by hand.
    def test_stages_by_hand_find_the_truth(self):
        scene = self.scene(imageSize=(720, 576), frames=100)
        model, camera, eye = scene.model(), scene.camera(), np.eye(4)
        params = st.PartTemplateRenderer.Params()
        params.wholeTool = True   # the outline is sampled from the same drawing
        renderer, matcher, verifier = st.PartTemplateRenderer.create(None, params), st.QGOMatcher.create(), st.GeometricContextVerifier.create()
        renderer.addTool(model)
        contour, search = st.ToolContour.create(model), st.ContourSearch()
        ekf = st.ArticulatedPoseEKF.create(model, scene.nominal_T_base(0), st.ArticulatedPoseEKF.Params())
        prior = st.ArticulatedPoseEKF.create(model, scene.nominal_T_base(0))
        errors = []
        for frame in range(8):
            ekf.predict(scene.recordedJoints(0, frame / 25.), 3 if 0 < frame < 4 else 1)
            ekf.copyTo(prior)
            half = 110 if frame == 0 else 25
            matcher.setImage(scene.render(frame))
            for attempt in range(3 if frame == 0 else 1):   # the first drawing is far off
                templates = renderer.render(camera, [ekf.view()], 0)
                windows = [(t.anchor[0] - half, t.anchor[1] - half, 2 * half + 1, 2 * half + 1) for t in templates]
                found, inliers = verifier.verify(matcher.match(templates, windows))
                self.assertTrue(found, frame)
                parts, image_points = [m.part for m in inliers], [m.imagePoint for m in inliers]
                ekf.begin()
                passed, used = ekf.addPoints(camera, eye, parts, image_points)
                self.assertEqual((len(used), np.count_nonzero(used)), (len(parts), passed))
                self.assertGreaterEqual(passed, 3)
                self.assertTrue(ekf.solve())
                half = 25
            outline = contour.sample(camera, ekf.view(), self.drawing(renderer, camera, ekf.view()), 1)
            for reach in (8., 5., 3.):
                search.halfWindow = reach
                outline = st.placeContour(camera, ekf.view(), outline)
                count, outline = st.matchContour(scene.render(frame), outline, search)
                self.assertGreater(count, 20)
                ekf.begin()
                ekf.addPoints(camera, eye, parts, np.array(image_points), [1.] * len(parts), reach)
                self.assertGreater(ekf.addContour(camera, eye, outline, reach / 2), 20)
                self.assertTrue(np.isfinite(ekf.surprise(0.02, 0.002)))
                self.assertTrue(ekf.solve())
            view = ekf.view()
            pose = view.camera_T_base @ model.endEffectorFromLinks(view.linkPoses())
            errors.append(np.linalg.norm(pose[:3, 3] - scene.truePose(0, frame / 25.)[:3, 3]))
        nominal = scene.nominal_T_base(0) @ model.endEffectorPose(scene.recordedJoints(0, frame / 25.))
        self.assertGreater(np.linalg.norm(nominal[:3, 3] - scene.truePose(0, frame / 25.)[:3, 3]), 0.003)   # what there was to find
        self.assertLess(max(errors[3:]), 0.001, errors)
        np.testing.assert_allclose(view.camera_T_base, ekf.correction() @ scene.nominal_T_base(0), atol=1e-12)   # rounding
        self.assertEqual(ekf.covariance().shape, (10, 10))
        self.assertLess(np.trace(ekf.covariance()), np.trace(prior.covariance()))   # by the last frame
        self.assertEqual(ekf.offsets().shape, (7,))
        self.assertTrue((ekf.offsets()[:3] == 0).all() and (ekf.offsets()[3:] != 0).all())
        self.assertGreater(np.linalg.eigvalsh(ekf.poseCovariance()).min(), 0)
        self.assertEqual(ekf.imageCovariance(camera, eye, 0).shape, (2, 2))
        self.assertTrue(ekf.nis() > 0)
        found = ekf.correction()
        ekf.undo()
        np.testing.assert_array_equal(ekf.correction(), prior.correction())
        before = np.trace(ekf.covariance())
        ekf.inflate(0.1, 0.01)
        self.assertAlmostEqual(np.trace(ekf.covariance()) - before, 3 * (0.01 + 0.0001), places=9)   # rounding
        ekf.reset(found)
        np.testing.assert_array_equal(ekf.correction(), found)
        self.assertFalse(ekf.solve())   # nothing was added
        ekf.reset()
        np.testing.assert_array_equal(ekf.correction(), eye)
        for bad in (lambda: ekf.predict([0.]), lambda: ekf.addPoints(camera, eye, [99], [(0., 0.)]), lambda: ekf.addPoints(camera, eye, [0], []),
                    lambda: ekf.copyTo(None), lambda: ekf.imageCovariance(camera, np.zeros((4, 4)), 0), lambda: ekf.reset(np.zeros((4, 4)))):
            with self.assertRaises(cv.error):
                bad()

    def drawing(self, renderer, camera, view):
        renderer.render(camera, [view], 0)
        return renderer.rendering()

    def test_sequence_reads_what_the_scene_writes(self):
        scene = self.scene(tools=2, stereo=True, distortion=True)
        scene.write(self.folder)
        sequence = st.Sequence.load(self.folder)
        self.assertEqual((sequence.toolCount(), sequence.fps(), sequence.isStereo()), (2, 25, True))
        self.assertEqual(tuple(sequence.leftCamera().imageSize()), (360, 288))
        np.testing.assert_allclose(sequence.right_T_left(), scene.right_T_left(), atol=1e-15)   # 17 digits
        self.assertEqual(sequence.tool(1).name, 'PSM2')
        np.testing.assert_allclose(sequence.tool(1).nominal_T_base, scene.nominal_T_base(1), atol=1e-12)   # 17 digits
        self.assertTrue(os.path.exists(sequence.tool(0).model))
        found, joints = sequence.jointsAt(0, 0.04)
        self.assertTrue(found)
        np.testing.assert_allclose(joints, scene.recordedJoints(0, 0.04), atol=1e-6)   # nine digits in the file
        found, jaw = sequence.jointsAt(0, 0.04, ['jaw'])
        self.assertEqual(list(jaw), [joints[list(sequence.jointNames()).index('jaw')]])
        self.assertFalse(sequence.jointsAt(0, 99.)[0])
        self.assertLess(sequence.firstTime(0), sequence.lastTime(0))
        found, pose, true_joints = sequence.groundTruth(1, 5)
        self.assertTrue(found)
        np.testing.assert_allclose(pose, scene.truePose(1, 0.2), atol=1e-8)            # nine digits in the file
        np.testing.assert_allclose(true_joints, scene.trueJoints(1, 0.2), atol=1e-8)   # nine digits in the file
        self.assertFalse(sequence.groundTruth(1, 6)[0])
        self.assertTrue(sequence.hasGroundTruth())
        self.assertEqual(sequence.groundTruthEnd(), 6)
        self.assertEqual(sequence.groundTruthFile(), self.path('groundtruth.csv'))
        self.assertEqual(sequence.keypointsFile(), self.path('keypoints.csv'))
        self.assertTrue(sequence.hasKeypoints())
        points = sequence.keypoints(1, 5)
        self.assertEqual([p.name for p in points], list(scene.model().keypointNames()))
        projected = scene.camera().projectPoints(np.array([p.cameraPoint for p in points])).reshape(-1, 2)
        np.testing.assert_allclose([p.imagePoint for p in points], projected, atol=1e-4)   # nine digits in the file
        self.assertTrue(any(p.visible for p in points) and not all(p.visible for p in points))
        self.assertEqual(len(sequence.keypoints(1, 6)), 0)
        video = cv.VideoCapture(sequence.leftVideo())
        self.assertEqual(video.get(cv.CAP_PROP_FRAME_COUNT), 6)

    def test_time_offset(self):
        self.scene(imageSize=(720, 576), frames=80).write(self.folder)
        filename = self.path('kinematics.csv')
        with open(filename) as f:
            header, *lines = f.read().splitlines()
        with open(filename, 'w') as f:
            f.write(header + '\n')
            for line in lines:
                time, rest = line.split(',', 1)
                f.write('%.4f,%s\n' % (float(time) + 0.36, rest))
        sequence = st.Sequence.load(self.folder)
        params = st.TimeOffsetParams()
        params.frames, params.range = 20, 0.8
        known, found = st.estimateTimeOffset(sequence, params=params)
        self.assertTrue(known, found.reason)
        self.assertAlmostEqual(found.offset, 0.36, delta=0.02)   # half a frame
        self.assertTrue(0 < found.deviation < params.maxDeviation)
        self.assertTrue(params.minConfidence < found.confidence <= 1)
        self.assertGreater(found.support, 0)
        self.assertLessEqual(found.frames, params.frames)
        self.assertEqual(found.reason, '')
        params.range = -1.
        with self.assertRaises(cv.error):
            st.estimateTimeOffset(sequence, params=params)
        params.range, params.expected = 0.8, 100.
        known, found = st.estimateTimeOffset(sequence, params=params)
        self.assertFalse(known)
        self.assertIn('of the video', found.reason)

    def test_every_parameter_has_a_name(self):
        params, stages = st.ToolTracker.Params(), st.ToolTracker.Stages()
        st.writeTrackerParams(self.path('all.yaml'), params, stages)
        file = cv.FileStorage(self.path('all.yaml'), cv.FILE_STORAGE_READ)
        fields = {'': params}
        fields.update((name, getattr(stages, name)) for name in dir(stages) if not name.startswith('_'))
        for group, owner in fields.items():
            node = file.getNode(group) if group else file.root()
            names = {name for name in dir(owner) if not name.startswith('_')}
            self.assertEqual(set(node.keys()) - set(fields), names, group)
        params, stages = st.setTrackerParam('matcher.candidates', '7', params, stages)
        self.assertEqual(stages.matcher.candidates, 7)
        st.writeTrackerParams(self.path('seven.yaml'), params, stages)
        params, stages = st.readTrackerParams(self.path('seven.yaml'), st.ToolTracker.Params(), st.ToolTracker.Stages())
        self.assertEqual(stages.matcher.candidates, 7)

    def test_setup_is_checked(self):
        self.scene(imageSize=(720, 576), frames=40).write(self.folder)
        sequence = st.Sequence.load(self.folder)
        findings, figures = st.checkSetup(sequence)
        self.assertEqual(findings, ())
        self.assertTrue(figures[0].startswith('PSM1: '), figures)
        st.writeHandEye(self.folder, 'PSM1', np.linalg.inv(sequence.tool(0).nominal_T_base))
        findings, figures = st.checkSetup(st.Sequence.load(self.folder))
        self.assertIn('base_T_camera', findings[0])
        self.assertEqual(st.checkUnits(self.model, np.full((3, 7), 0.1)), '')
        self.assertIn('radians', st.checkUnits(self.model, np.full((3, 7), 50.)))

    def test_imported_files_become_a_sequence(self):
        with open(self.path("left.yaml"), "w") as f:   # as ROS writes it
            f.write("image_width: 720\nimage_height: 576\ndistortion_model: plumb_bob\n"
                    "camera_matrix:\n  rows: 3\n  cols: 3\n  data: [818.5, 0, 360, 0, 822, 288, 0, 0, 1]\n"
                    "distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [-0.2, 0.1, 0, 0, 0]\n")
        with open(self.path("js.csv"), "w") as f:
            f.write("header.stamp,position[0],position[1],position[2],position[3],position[4],position[5],position[6]\n")
            for k in range(3):
                f.write("%d,0.1,0.2,0.12,0.4,0.5,0.6,0.%d\n" % (1700000000000000000 + k * 10000000, k))
        cameras = st.importCameraInfo([self.path("left.yaml")])
        self.assertEqual(cameras.left.cameraMatrix()[0, 0], 818.5)
        self.assertEqual(tuple(cameras.right.imageSize()), (0, 0))
        names = self.model.coordinateNames()
        times, joints = st.importJoints([self.path("js.csv")], names)
        self.assertEqual(joints.shape, (3, 7))
        self.assertEqual(joints[2, 6], 0.2)
        st.writeSequenceCameras(self.path("s"), cameras, "left.mp4", "", 25)
        st.writeSequenceTool(self.path("s"), "PSM1", "tool.yaml", np.eye(4))
        st.writeSequenceJoints(self.path("s"), "PSM1", names, np.subtract(times, times[0]), joints)
        sequence = st.Sequence.load(self.path("s"))
        self.assertEqual(sequence.fps(), 25)
        self.assertEqual(sequence.tool(0).model, os.path.join(self.path("s"), "tool.yaml"))
        self.assertAlmostEqual(sequence.jointsAt(0, 0.01)[1][6], 0.1, 6)   # a clock of seconds since 1970 resolves 0.2 microseconds

    def test_imported_tools_take_parts_from_another(self):
        self.model.save(self.path("driver.yaml"))
        with open(self.path("tool.urdf"), "w") as f:
            f.write('<robot name="shaft"><link name="base"/><link name="shaft"/><link name="wrist"/><link name="yaw"/><link name="jaw_right"/>'
                    '<link name="jaw_left"/>' + ''.join(
                        '<joint name="%s" type="continuous"><parent link="%s"/><child link="%s"/><axis xyz="0 0 1"/></joint>' % joint for joint in
                        (("q4", "base", "shaft"), ("q5", "shaft", "wrist"), ("q6", "wrist", "yaw"), ("right", "yaw", "jaw_right"),
                         ("left", "yaw", "jaw_left"))) + '</robot>')
        parts = st.ToolParts()
        parts.like = self.path("driver.yaml")
        try:
            tool = st.importUrdfTool(self.path("tool.urdf"), parts)
        except cv.error as e:
            if e.code != cv.Error.StsNotImplemented:
                raise
            self.skipTest(e.err)
        self.assertEqual(sorted(tool.coordinateNames()), ["left", "q4", "q5", "q6", "right"])
        self.assertEqual(tool.keypointNames(), self.model.keypointNames())
        parts.endEffector = "elbow"
        with self.assertRaises(cv.error):
            st.importUrdfTool(self.path("tool.urdf"), parts)

    def test_scene_is_deterministic(self):
        image = self.scene().render(3)
        self.assertEqual((image.shape, image.dtype), ((288, 360, 3), np.uint8))
        np.testing.assert_array_equal(image, self.scene().render(3))
        self.assertEqual(self.scene(tools=2).toolCount(), 2)
        self.assertEqual(self.scene().frameCount(), 6)
        self.assertEqual(self.scene().model().name(), self.model.name())
        scene = self.scene(tools=2)   # the arms as they are, and after a knock
        joints, bases = [scene.trueJoints(i, 3 / 25.) for i in (0, 1)], [scene.camera_T_base(i) for i in (0, 1)]
        np.testing.assert_array_equal(scene.renderArms(3, joints, bases), scene.render(3))
        knocked = scene.renderArms(3, joints, np.array([rigid([0, 0, 0], [0.01, 0, 0]) @ T for T in bases]))
        self.assertGreater(np.count_nonzero(knocked != scene.render(3)), 1000)
        with self.assertRaises(cv.error):
            scene.renderArms(3, joints, bases[:1])

    def test_pose_writer(self):
        filename = self.path('poses.csv')
        writer = st.PoseWriter.create(filename, ['nis'])
        writer.write(7, 0.28, 'PSM1', st.STATE_TRACKING, rigid([0, 0, np.pi / 2], [0.1, 0.2, 0.3]), [float('nan')])
        with self.assertRaises(cv.error):
            writer.write(8, 0.32, 'PSM1', st.STATE_TRACKING, np.full((4, 4), np.nan), [1.])
        with open(filename) as f:
            lines = f.read().splitlines()
        self.assertEqual(lines[0], 'frame,time,tool,status,tx,ty,tz,qx,qy,qz,qw,nis')
        cells = lines[1].split(',')
        self.assertEqual((cells[0], cells[2], cells[3], cells[11]), ('7', 'PSM1', 'tracking', ''))
        np.testing.assert_allclose([float(c) for c in cells[4:11]], [0.1, 0.2, 0.3, 0, 0, 0.5 ** 0.5, 0.5 ** 0.5], atol=1e-9)   # nine decimals
        self.assertEqual(len(lines), 2)

    def test_pose_writer_takes_estimates(self):
        filename = self.path('poses.csv')
        writer = st.PoseWriter.create(filename, ['PSM1'], [self.model], ['dropped'])
        estimate = st.ToolEstimate()
        estimate.state, estimate.camera_T_tool, estimate.similarity = st.STATE_TRACKING, rigid([0, 0, 0], [0, 0, 0.1]), 0.75
        estimate.jointOffsets = [0., 0., 0., 0.01, 0.02, 0.03, 0.04]
        writer.write(7, 0.28, 'PSM1', estimate, [2.])
        with self.assertRaises(cv.error):
            writer.write(7, 0.28, 'PSM2', estimate, [2.])
        with open(filename) as f:
            header, row = [line.split(',') for line in f.read().splitlines()]
        cells = dict(zip(header, row))
        self.assertEqual([cells[c] for c in ('tool', 'status', 'tz', 'similarity', 'sd_rx', 'offset_jaw', 'dropped')],
                         ['PSM1', 'tracking', '0.100000000', '0.75', '', '0.04', '2'])

    def test_pose_scorer(self):
        scorer = st.PoseScorer.create(self.camera, [self.model])
        truth = rigid([0, 0, 0], [0, 0, 0.1])
        scorer.add(0, st.STATE_TRACKING, rigid([0, 0, 0.1], [0, 0, 0.1]), truth)
        scorer.add(0, st.STATE_LOST, truth, truth)
        score = scorer.score()
        self.assertEqual((score.frames, score.covered), (2, 1))
        self.assertAlmostEqual(score.rotationMean, 0.1)
        self.assertAlmostEqual(score.translationMean, 0)
        self.assertEqual(score.accuracy, 0.5)
        self.assertEqual(score.silent, 0)
        self.assertAlmostEqual(score.translationStd, 0)
        self.assertAlmostEqual(score.rotationStd, 0)

    def test_pose_error(self):
        estimate, truth = rigid([0.1, 0, 0], [0, 0, 0.1]), rigid([0.1, 0, 0], [0, 0, 0.1])
        truth[:3, :3] = rigid([0, 0.2, 0], [0, 0, 0])[:3, :3].dot(estimate[:3, :3])
        truth[0, 3] = 0.003
        error = st.poseError(estimate, truth)
        np.testing.assert_allclose(error.ravel(), [0, 0.2, 0, 0.003, 0, 0], atol=1e-12)   # rounding
        covariance = np.diag([0.01, 0.01, 0.01, 1e-6, 1e-6, 1e-6])
        self.assertAlmostEqual(st.normalizedErrorSquared(error, covariance), 4 + 9)
        self.assertAlmostEqual(st.normalizedErrorSquared(error, covariance, 3, 3), 9)
        self.assertTrue(np.isnan(st.normalizedErrorSquared(error, np.zeros((6, 6)))))

    def test_tracker_tracks_the_scene(self):
        scene = self.scene(imageSize=(720, 576), frames=25)
        params = st.ToolTracker.Params()
        params.method = st.METHOD_PAPER
        tracker = st.ToolTracker.create(scene.camera(), params)
        self.assertEqual(tracker.addTool(scene.model(), scene.nominal_T_base(0)), 0)
        scorer = st.PoseScorer.create(scene.camera(), [scene.model()])
        for frame in range(12):
            time = frame / 25.
            image, joints = scene.render(frame), scene.recordedJoints(0, time)
            if frame >= 6:
                tracker.renderAhead([scene.recordedJoints(0, time + 1 / 25.)])
            estimate, = tracker.update(image, time, [joints])
            scorer.add(0, estimate.state, estimate.camera_T_tool, scene.truePose(0, time))
        self.assertEqual(st.stateName(estimate.state), 'tracking')
        self.assertEqual(estimate.covariance.shape, (6, 6))
        self.assertGreaterEqual(estimate.inliers, 4)
        self.assertGreaterEqual(estimate.visibleParts, estimate.inliers)
        self.assertEqual(len(estimate.matches), estimate.inliers)
        self.assertTrue(0 < estimate.similarity <= 1)
        self.assertTrue(np.isfinite(estimate.nis))
        tool = estimate.camera_T_nominal.dot(scene.nominal_T_base(0)).dot(scene.model().endEffectorPose(joints))
        np.testing.assert_allclose(estimate.camera_T_tool, tool, atol=1e-9)   # the chain of transforms
        np.testing.assert_array_equal(estimate.joints, np.array(joints) + estimate.jointOffsets)
        drawn = st.drawEstimate(image.copy(), scene.camera(), scene.model(), estimate, 'PSM1')
        self.assertGreater(np.count_nonzero(drawn != image), 10000)
        base = st.DrawnTool(scene.model(), estimate).camera_T_base
        np.testing.assert_allclose(base, estimate.camera_T_nominal.dot(scene.nominal_T_base(0)), atol=1e-9)   # the same chain
        self.assertLess(scorer.score().translationMean, 0.0016)   # measured: 0.82 mm; the calibration is 6 mm off
        times = tracker.getTimings()
        self.assertEqual([t.name for t in times], ['render', 'image', 'match', 'verify', 'filter', 'contour', 'total'])
        for t in times:
            self.assertEqual(t.calls, 12)
            self.assertTrue(0 <= t.min <= t.mean <= t.max and t.min <= t.last <= t.max)
        tracker.resetTimings()
        self.assertEqual(tracker.getTimings()[-1].calls, 0)
        with self.assertRaises(cv.error):
            tracker.renderAhead([joints[:2]])
        with self.assertRaises(cv.error):
            tracker.update(image[:100], 9., [joints])
        tracker.reset()
        before = image.copy()
        st.drawSkeleton(image, scene.camera(), scene.model(), joints, scene.camera_T_base(0), (0, 255, 0))
        self.assertGreater(np.count_nonzero(image != before), 100)

    # Structures that users store: an estimate of a tracked tool and one of its matches, a time and a score.
    def values(self):
        scene = self.scene(imageSize=(720, 576), frames=25)
        tracker = st.ToolTracker.create(scene.camera())
        tracker.addTool(scene.model(), scene.nominal_T_base(0))
        scorer = st.PoseScorer.create(scene.camera(), [scene.model()])
        for frame in range(2):
            time = frame / 25.
            estimate, = tracker.update(scene.render(frame), time, [scene.recordedJoints(0, time)])
            scorer.add(0, estimate.state, estimate.camera_T_tool, scene.truePose(0, time))
        return [estimate, estimate.matches[0], tracker.getTimings()[-1], scorer.score()]

    # All fields, of whatever names.
    def fields(self, value):
        result = {}
        for name in dir(value):
            if not name.startswith('_'):
                field = getattr(value, name)
                is_list = isinstance(field, tuple) and field and not isinstance(field[0], (int, float))
                result[name] = [self.fields(item) for item in field] if is_list else field
        return result

    def assert_same(self, a, b):
        self.assertIs(type(a), type(b))
        np.testing.assert_equal(self.fields(a), self.fields(b))

    def test_values_are_copied_and_pickled(self):
        values = self.values()
        self.assertEqual(values[0].state, st.STATE_TRACKING)
        self.assertGreater(len(values[0].matches), 4)
        self.assert_same(self.values()[0], values[0])   # the same input, the same estimate
        for value in values + [type(value)() for value in values]:
            for copied in [copy.copy(value), copy.deepcopy(value)] + [pickle.loads(pickle.dumps(value, p)) for p in range(pickle.HIGHEST_PROTOCOL + 1)]:
                self.assertIsNot(copied, value)
                self.assert_same(copied, value)
        estimate = values[0]
        copied = copy.copy(estimate)
        copied.state, copied.camera_T_tool, copied.matches = st.STATE_LOST, np.eye(4), ()
        self.assertEqual((estimate.state, len(estimate.matches)), (st.STATE_TRACKING, estimate.inliers))
        self.assertGreater(np.abs(estimate.camera_T_tool - np.eye(4)).max(), 0.01)

    def test_values_are_unpickled_by_another_program(self):
        values = self.values()
        with open(self.path('values.pickle'), 'wb') as f:
            pickle.dump(values, f)
        code = 'import pickle, sys; print([repr(v) for v in pickle.load(open(sys.argv[1], "rb"))])'   # which has not imported cv2
        text = subprocess.check_output([sys.executable, '-c', code, self.path('values.pickle')], universal_newlines=True)
        self.assertEqual(text.strip(), str([repr(v) for v in values]))

    def test_values_can_be_read(self):
        estimate, match, time, score = self.values()
        text = repr(estimate)
        self.assertEqual(text, str(estimate))
        self.assertRegex(text, r'^ToolEstimate\(.*\bstate=tracking\b.*\)$')
        self.assertIn('inliers=%d, ' % estimate.inliers, text)
        self.assertIn('matches=%d PartMatch' % estimate.inliers, text)
        self.assertIn('covariance=6x6 array', text)
        self.assertIn('camera_T_tool=[[%.6g, ' % estimate.camera_T_tool[0, 0], text)
        self.assertNotIn('\n', text)
        for name in self.fields(estimate):
            self.assertIn(name + '=', text)
        self.assertIn('imagePoint=[%.6g, %.6g]' % match.imagePoint, repr(match))
        self.assertRegex(repr(time), r"^StageTime\(calls=2, .*name='total'\)$")
        self.assertIn('frames=2, ', repr(score))
        self.assertEqual(repr(st.StageTime()), "StageTime(calls=0, last=0, max=0, mean=0, min=0, name='')")
        self.assertIn('matches=[]', repr(st.ToolEstimate()))

    def test_draws_tools_over_an_image(self):
        renderer = st.MeshRenderer.createSoftware()
        ids = renderer.renderTool(self.model, self.joints, self.camera_T_base(), self.camera)[1]
        image = np.full((576, 720, 3), 200, np.uint8)
        drawn = st.drawTool(image.copy(), self.camera, self.model, self.joints, self.camera_T_base(), (0, 0, 255), 1., renderer)
        np.testing.assert_array_equal((drawn != image).any(axis=2), ids > 0)
        tool = st.DrawnTool(self.model, self.joints, self.camera_T_base(), (0, 0, 255), 1.)
        np.testing.assert_array_equal(st.drawTools(image.copy(), self.camera, [tool], renderer), drawn)
        tool.opacity = 2
        self.assertEqual(tool.opacity, 2)
        with self.assertRaises(cv.error):
            st.drawTools(image, self.camera, [tool])
        with self.assertRaises(cv.error):
            st.drawTools(image, self.camera, [st.DrawnTool()])

    def test_draws_what_the_stages_see(self):
        renderer = st.PartTemplateRenderer.create()
        renderer.addTool(self.model)
        templates = renderer.renderTool(self.camera, self.camera_T_base(), self.joints)
        view = np.full((576, 720, 3), 80, np.uint8)
        st.drawTools(view, self.camera, [st.DrawnTool(self.model, self.joints, self.camera_T_base(), (255, 255, 255), 1.)], None, 0)
        orientations = st.quantizeOrientations(view)
        picture = st.drawOrientations(np.zeros_like(view), orientations)
        np.testing.assert_array_equal(picture.any(axis=2), orientations > 0)
        self.assertTrue(st.drawOrientationLegend(np.zeros_like(view), (100, 100), 50)[100, 130].any())
        self.assertEqual(len({st.orientationColor(i) for i in range(8)}), 8)
        features = st.drawTemplate(np.zeros_like(view), templates[0], templates[0].anchor)
        self.assertEqual(np.count_nonzero(features.any(axis=2)), len(templates[0].getFeatures()))
        matcher, verifier = st.QGOMatcher.create(), st.GeometricContextVerifier.create()
        matcher.setImage(view)
        window = (templates[0].anchor[0] - 20, templates[0].anchor[1] - 20, 41, 41)
        self.assertEqual(st.drawSimilarity(matcher.similarityMap(templates[0], window), templates[0]).shape, (41, 41, 3))
        matches = matcher.match(templates, [])
        found, inliers = verifier.verify(matches)
        self.assertTrue(found)
        self.assertEqual(len(verifier.sample()), 2)
        for drawn in (st.drawMatches(view.copy(), matches), st.drawGeometricContext(view.copy(), matches, inliers, verifier.sample(), True)):
            self.assertGreater(np.count_nonzero(drawn != view), 1000)
        points = st.ToolContour.create(self.model).sampleTool(self.camera, self.camera_T_base(), self.joints)
        count, points = st.matchContour(view, points, st.ContourSearch())
        self.assertGreater(count, 0.8 * len(points))   # an image of nothing but the tool
        self.assertGreater(np.count_nonzero(st.drawContour(view.copy(), points) != view), 1000)

    def test_scene_view(self):
        try:
            scene = st.SceneView.create(self.camera, (320, 240))
        except cv.error as error:
            self.skipTest(error.err)
        scene.setViewpoint((0.1, -0.1, -0.1), (0, 0, 0.08))
        tool = st.DrawnTool(self.model, self.joints, self.camera_T_base(), (0, 0, 255), 1.)
        path = np.array([[0, 0, 0.05], [0.01, 0, 0.1]])
        picture = scene.draw(np.zeros((576, 720, 3), np.uint8), [tool], [path])
        self.assertEqual(picture.shape, (240, 320, 3))
        red = (picture[:, :, 2] > 60) & (picture[:, :, 0] < 40) & (picture[:, :, 1] < 40)
        self.assertGreater(np.count_nonzero(red), 200)
        with self.assertRaises(cv.error):
            scene.show()

    def test_full_method_tracks_with_both_eyes(self):
        scene = self.scene(imageSize=(720, 576), frames=25, stereo=True)
        params = st.ToolTracker.Params()
        params.method = st.METHOD_FULL
        for eyes in (1, 2):
            tracker = st.ToolTracker.create(scene.camera(), params)
            if eyes == 2:
                tracker.setRightCamera(scene.camera(right=True), scene.right_T_left())
            tracker.addTool(scene.model(), scene.nominal_T_base(0))
            scorer = st.PoseScorer.create(scene.camera(), [scene.model()])
            for frame in range(8):
                time = frame / 25.
                image, joints = scene.render(frame), scene.recordedJoints(0, time)
                if eyes == 1:
                    estimate, = tracker.update(image, time, [joints])
                else:
                    estimate, = tracker.updateStereo(image, scene.render(frame, right=True), time, [joints])
                scorer.add(0, estimate.state, estimate.camera_T_tool, scene.truePose(0, time))
            self.assertEqual(estimate.state, st.STATE_TRACKING)
            offsets = np.ravel(estimate.jointOffsets)
            self.assertEqual(offsets.shape, (7,))
            np.testing.assert_array_equal(offsets[:3], 0)   # the arm's readings have none
            self.assertTrue((offsets[3:] != 0).all())
            self.assertTrue(0 < estimate.contourSupport <= 1)
            self.assertEqual(estimate.covariance.shape, (6, 6))
            self.assertGreater(np.linalg.eigvalsh(estimate.covariance).min(), 0)
            self.assertLess(np.abs(estimate.joints - (np.ravel(joints) + offsets)).max(), abs(estimate.delay) * 1.5 + 1e-9)   # no joint is faster [rad/s]
            tool = estimate.camera_T_nominal.dot(scene.nominal_T_base(0)).dot(scene.model().endEffectorPose(estimate.joints))
            np.testing.assert_allclose(estimate.camera_T_tool, tool, atol=1e-9)   # the chain of transforms
            self.assertLess(scorer.score().translationMean, 0.0004 if eyes == 1 else 0.0003)   # measured: 0.21 and 0.15 mm; the calibration is 6 mm off
        with self.assertRaises(cv.error):   # no right camera is known
            st.ToolTracker.create(scene.camera(), params).updateStereo(image, image, 0., [])

    # A board on the instrument, in front of a camera that stands.
    def hand_eye_recording(self, poses):
        rng = np.random.RandomState(3)
        camera_T_base, tool_T_board = rigid([0.5, 2, -1], [0.05, -0.08, 0.03]), rigid([0.2, 2.9, -0.3], [0.004, -0.006, 0.012])
        board = [rigid(rng.uniform(-0.5, 0.5, 3), rng.uniform([-0.02, -0.015, 0.08], [0.02, 0.015, 0.12])) for _ in range(poses)]
        robot = [np.linalg.inv(camera_T_base).dot(T).dot(np.linalg.inv(tool_T_board)) for T in board]
        return camera_T_base, np.array(robot), np.array(board)

    def test_hand_eye(self):
        camera_T_base, robot, board = self.hand_eye_recording(12)
        points = st.getBoardPoints(st.CalibrationBoard())
        self.assertEqual(points.shape, (44, 3))
        told, result = st.estimateHandEye(robot, board, camera=self.camera, boardPoints=points)
        self.assertTrue(told, result.reason)
        np.testing.assert_allclose(result.best.camera_T_mount, camera_T_base, atol=1e-9)   # exact but for rounding
        self.assertEqual([st.handEyeMethodName(fit.method) for fit in result.fits],
                         ['tsai', 'park', 'horaud', 'andreff', 'daniilidis', 'shah', 'li', 'refined'])
        self.assertEqual(len(result.rejected), 0)
        self.assertEqual(len(result.warnings), 0)
        self.assertEqual(result.residuals.shape, (12, 3))
        params = st.HandEyeParams()
        params.setup, params.method = st.HAND_EYE_CAMERA_ON_ARM, st.HAND_EYE_TSAI
        told, result = st.estimateHandEye(np.linalg.inv(robot), board, params)
        self.assertTrue(told, result.reason)
        self.assertEqual(result.best.method, st.HAND_EYE_TSAI)
        np.testing.assert_allclose(result.best.camera_T_mount, camera_T_base, atol=1e-9)   # the same by the other set-up
        with self.assertRaises(cv.error):
            st.estimateHandEye(robot[:3], board[:3])

    def test_hand_eye_files(self):
        filename = self.path('poses.csv')
        with open(filename, 'w') as poses:
            poses.write('index,tx,ty,tz,qx,qy,qz,qw\n3,0.1,0.2,0.3,0,0,0,1\n7,0,0,0.1,0,0,0.6,0.8\n')
        by_time, keys, matrices = st.readPoses(filename)
        self.assertFalse(by_time)
        np.testing.assert_array_equal(np.ravel(keys), [3, 7])
        np.testing.assert_array_equal(matrices.reshape(-1, 4, 4)[0, :3, 3], [0.1, 0.2, 0.3])
        folder = self.path('sequence')
        self.scene().write(folder)
        before = st.Sequence.load(folder)
        camera_T_base = rigid([0.1, 0.2, 0.3], [0.01, -0.02, 0.03])
        st.writeHandEye(folder, before.tool(0).name, camera_T_base)
        np.testing.assert_array_equal(st.Sequence.load(folder).tool(0).nominal_T_base, camera_T_base)
        with self.assertRaises(cv.error):
            st.writeHandEye(folder, 'none', camera_T_base)

    def test_board_is_found(self):
        image = np.full((576, 720), 230, np.uint8)
        for x, y, _ in st.getBoardPoints(st.CalibrationBoard()) / 0.0015 * 20:
            cv.circle(image, (int(16 * (250 + x)), int(16 * (180 + y))), 16 * 8, 25, cv.FILLED, cv.LINE_AA, 4)   # 1/16 pixel
        found, camera_T_board, points, error = st.findBoard(image, self.camera, st.CalibrationBoard())
        self.assertTrue(found)
        self.assertEqual(points.shape, (44, 2))
        self.assertLess(error, 1)   # fx is not quite fy
        self.assertAlmostEqual(camera_T_board[2, 3], 0.0615, delta=0.002)   # 820 pixel * 1.5 mm / 20 pixel
        self.assertFalse(st.findBoard(np.zeros_like(image), self.camera, st.CalibrationBoard())[0])


if __name__ == '__main__':
    NewOpenCVTests.bootstrap()
