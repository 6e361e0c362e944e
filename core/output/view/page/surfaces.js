// Planes and instruments, and the triangles of the bodies' surfaces.
(function (s) {
  const run = s.run, radius = s.camera.radius;

  // A square of the plane below (or beside) the network, with lines at round lengths.
  function make_plane(surface) {
    const normal = new THREE.Vector3().fromArray(surface.normal).normalize();
    const point = new THREE.Vector3().fromArray(surface.point);
    const cell = s.round_down(radius / 2);
    const half = cell * Math.ceil(1.35 * radius / cell);
    const group = new THREE.Group();
    const turn = new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 0, 1), normal);
    const sheet = new THREE.Mesh(new THREE.PlaneBufferGeometry(2 * half, 2 * half), new THREE.MeshBasicMaterial({
      color: 0xcfd8e1, transparent: true, opacity: 0.42, side: THREE.DoubleSide, depthWrite: false }));
    const corners = [];
    for (let x = -half; x <= half * 1.0001; x += cell) corners.push(x, -half, 0, x, half, 0, -half, x, 0, half, x, 0);
    const geometry = new THREE.BufferGeometry().setAttribute("position", new THREE.Float32BufferAttribute(corners, 3));
    const lines = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: 0x9fb0c0, transparent: true, opacity: 0.8 }));
    sheet.renderOrder = -2;
    lines.renderOrder = -1;
    group.add(sheet, lines);
    group.quaternion.copy(turn);
    // The foot of the centre of the motion on the plane.
    const offset = s.camera.centre.clone().sub(point);
    offset.addScaledVector(normal, -offset.dot(normal));
    return { object: group, offset: offset, cell: cell };
  }

  function make_instrument(surface) {
    const material = new THREE.MeshPhongMaterial({ color: 0x7f93a8, transparent: true, opacity: 0.62, shininess: 60,
                                                   side: THREE.FrontSide, depthWrite: false });
    const group = new THREE.Group();
    const axis = new THREE.Vector3().fromArray(surface.to).sub(new THREE.Vector3().fromArray(surface.point));
    const length = axis.length();
    if (length > 0) {
      // One closed outline turned about the axis: no wall inside where parts would meet.
      const outline = [];
      for (let k = 0; k <= 12; ++k) {
        const a = k / 12 * Math.PI / 2;
        outline.push(new THREE.Vector2(surface.radius * Math.sin(a), -surface.radius * Math.cos(a)));
      }
      for (let k = 0; k <= 12; ++k) {
        const a = k / 12 * Math.PI / 2;
        outline.push(new THREE.Vector2(surface.radius * Math.cos(a), length + surface.radius * Math.sin(a)));
      }
      group.add(new THREE.Mesh(new THREE.LatheBufferGeometry(outline, 36), material));
      group.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), axis.normalize());
    } else {
      group.add(new THREE.Mesh(new THREE.SphereBufferGeometry(surface.radius, 40, 24), material));
    }
    group.children.forEach(function (mesh) { mesh.renderOrder = 3; });
    return { object: group, offset: new THREE.Vector3() };
  }

  s.Surfaces = function () {
    const group = new THREE.Group();
    const parts = run.about.surfaces.map(function (surface) {
      const part = surface.kind === "plane" ? make_plane(surface) : make_instrument(surface);
      group.add(part.object);
      return part;
    });
    this.group = group;
    const plane = parts.find(function (part) { return part.cell; });
    this.cell = plane ? plane.cell : 0;
    this.show = function (frame) {
      parts.forEach(function (part, k) { part.object.position.fromArray(run.surface(frame, k)).add(part.offset); });
    };
  };

  // Triangles, without those that are torn.
  s.Faces = function () {
    const count = run.face_frames.length;
    const positions = new Float32Array(3 * run.nodes), corners = new Uint32Array(run.faces.length);
    const geometry = new THREE.BufferGeometry();
    const place = new THREE.BufferAttribute(positions, 3), index = new THREE.BufferAttribute(corners, 1);
    geometry.setAttribute("position", place);
    geometry.setIndex(index);
    const material = new THREE.MeshPhongMaterial({ color: 0xe9d3bd, side: THREE.DoubleSide, shininess: 18, specular: 0x333333,
      polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 2 });
    this.mesh = new THREE.Mesh(geometry, material);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = 2;
    this.count = count;
    this.opacity = function (value) {
      material.opacity = value;
      material.transparent = value < 1;
      material.depthWrite = value > 0.6;
      material.needsUpdate = true;
    };
    this.show = function (frame) {
      positions.set(run.positions.row(frame));
      let used = 0;
      for (let k = 0; k < count; ++k) {
        if (frame >= run.face_frames[k]) continue;
        corners[used++] = run.faces[3 * k];
        corners[used++] = run.faces[3 * k + 1];
        corners[used++] = run.faces[3 * k + 2];
      }
      corners.fill(0, used);  // triangles without area
      geometry.setDrawRange(0, used);
      place.needsUpdate = true;
      index.needsUpdate = true;
      geometry.computeVertexNormals();
    };
  };
})(springnet);
