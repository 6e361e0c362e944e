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
    // Projection of the motion's centre onto the plane.
    const offset = s.camera.centre.clone().sub(point);
    offset.addScaledVector(normal, -offset.dot(normal));
    return { object: group, offset: offset, cell: cell };
  }

  // A box whose edges and corners are rounded: the outer cells of a grid on each side, projected onto the rounding.
  function box_geometry(surface) {
    const half = new THREE.Vector3().fromArray(surface.size).multiplyScalar(0.5), radius = surface.radius;
    if (!(radius > 0)) return new THREE.BoxBufferGeometry(2 * half.x, 2 * half.y, 2 * half.z);
    const subdivisions = 6, cells = 2 * subdivisions + 1, geometry = new THREE.BoxBufferGeometry(2, 2, 2, cells, cells, cells);
    const places = geometry.attributes.position, normals = geometry.attributes.normal;
    const point = new THREE.Vector3(), nearest = new THREE.Vector3();
    for (let k = 0; k < places.count; ++k) {
      point.fromBufferAttribute(places, k);
      ["x", "y", "z"].forEach(function (axis) {
        // Equal angles about the edge: tangents of 0 to 45 degrees.
        const from_edge = Math.min(Math.round((1 - Math.abs(point[axis])) / 2 * cells), subdivisions);
        const out = Math.tan((1 - from_edge / subdivisions) * Math.PI / 4);
        nearest[axis] = Math.sign(point[axis]) * (half[axis] - radius);
        point[axis] = nearest[axis] + Math.sign(point[axis]) * radius * out;
      });
      const normal = point.sub(nearest).normalize();
      normals.setXYZ(k, normal.x, normal.y, normal.z);
      places.setXYZ(k, nearest.x + radius * normal.x, nearest.y + radius * normal.y, nearest.z + radius * normal.z);
    }
    return geometry;
  }

  function make_instrument(surface) {
    const material = new THREE.MeshPhongMaterial({ color: 0x7f93a8, transparent: true, opacity: 0.62, shininess: 60,
                                                   side: THREE.FrontSide, depthWrite: false });
    const group = new THREE.Group();
    if (surface.kind === "box") {
      group.add(new THREE.Mesh(box_geometry(surface), material));
      group.quaternion.fromArray(surface.orientation);
      group.children[0].renderOrder = 3;
      return { object: group, offset: new THREE.Vector3() };
    }
    const axis = new THREE.Vector3().fromArray(surface.to).sub(new THREE.Vector3().fromArray(surface.point));
    const length = axis.length();
    if (length > 0) {
      // One closed outline turned about the axis, so that there are no walls inside, as between a cylinder and its caps.
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
    const rotation = new THREE.Quaternion();
    parts.forEach(function (part) { part.start_rotation = part.object.quaternion.clone(); });
    this.show = function (frame) {
      parts.forEach(function (part, k) {
        const pose = run.surface(frame, k);
        rotation.fromArray(pose, 3);
        part.object.quaternion.multiplyQuaternions(rotation, part.start_rotation);
        part.object.position.copy(part.offset).applyQuaternion(rotation).add(new THREE.Vector3().fromArray(pose));
      });
    };
  };

  // Triangles, except torn ones. Each has three corners of its own, whose normals are its own at sharp edges, and the mean
  // of the neighbours elsewhere.
  s.Faces = function () {
    const count = run.face_frames.length, sharp = Math.cos(35 * Math.PI / 180);
    const places = new Float32Array(9 * count), normals = new Float32Array(9 * count);
    const flat = new Float32Array(3 * count), smooth = new Float32Array(3 * run.nodes);
    const geometry = new THREE.BufferGeometry();
    const attributes = [new THREE.BufferAttribute(places, 3), new THREE.BufferAttribute(normals, 3)];
    geometry.setAttribute("position", attributes[0]);
    geometry.setAttribute("normal", attributes[1]);
    // The far side is drawn before the near one, through which it is seen.
    const sides = [THREE.BackSide, THREE.FrontSide].map(function (side) {
      return new THREE.MeshPhongMaterial({ color: 0xe9d3bd, side: side, shininess: 12, specular: 0x141414 });
    });
    this.mesh = new THREE.Group();
    sides.forEach(function (material, k) {
      const mesh = new THREE.Mesh(geometry, material);
      mesh.frustumCulled = false;
      mesh.renderOrder = 2 + 0.5 * k;
      this.mesh.add(mesh);
    }, this);
    this.count = count;
    this.opacity = function (value) {
      sides.forEach(function (material) {
        material.opacity = value;
        material.transparent = value < 1;
        material.depthWrite = value > 0.6;
        material.needsUpdate = true;
      });
    };

    // `flat`: unit normal of each triangle; `smooth`: at each node the mean normal, weighted by area.
    function find_normals(frame, positions) {
      smooth.fill(0);
      for (let k = 0; k < count; ++k) {
        if (frame >= run.face_frames[k]) continue;
        const a = 3 * run.faces[3 * k], b = 3 * run.faces[3 * k + 1], c = 3 * run.faces[3 * k + 2];
        const ux = positions[b] - positions[a], uy = positions[b + 1] - positions[a + 1], uz = positions[b + 2] - positions[a + 2];
        const vx = positions[c] - positions[a], vy = positions[c + 1] - positions[a + 1], vz = positions[c + 2] - positions[a + 2];
        const normal = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx], length = Math.hypot(normal[0], normal[1], normal[2]);
        for (let axis = 0; axis < 3; ++axis) {
          smooth[a + axis] += normal[axis];
          smooth[b + axis] += normal[axis];
          smooth[c + axis] += normal[axis];
          flat[3 * k + axis] = length > 0 ? normal[axis] / length : 0;
        }
      }
      for (let k = 0; k < smooth.length; k += 3) {
        const length = Math.hypot(smooth[k], smooth[k + 1], smooth[k + 2]);
        for (let axis = 0; length > 0 && axis < 3; ++axis) smooth[k + axis] /= length;
      }
    }
    this.show = function (frame, positions) {
      find_normals(frame, positions);
      let used = 0;
      for (let k = 0; k < count; ++k) {
        if (frame >= run.face_frames[k]) continue;
        for (let corner = 0; corner < 3; ++corner, used += 3) {
          const node = 3 * run.faces[3 * k + corner];
          const bend = flat[3 * k] * smooth[node] + flat[3 * k + 1] * smooth[node + 1] + flat[3 * k + 2] * smooth[node + 2];
          for (let axis = 0; axis < 3; ++axis) {
            places[used + axis] = positions[node + axis];
            normals[used + axis] = bend > sharp ? smooth[node + axis] : flat[3 * k + axis];
          }
        }
      }
      geometry.setDrawRange(0, used / 3);
      attributes.forEach(function (attribute) { attribute.needsUpdate = true; });
    };
  };
})(springnet);
