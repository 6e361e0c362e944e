// Lines of any width in pixels, shaded like thin rods: WebGL itself draws lines only one pixel wide.
(function (s) {
  const vertex = `
    // position: end 0 or 1, side -1 or 1, 0
    attribute vec3 first, second, tint;
    uniform vec2 pixels;
    uniform float width, near;
    uniform vec2 depth;  // of the nearest and the farthest part
    varying vec3 colour;
    varying float side, along;
    void main() {
      vec4 a = modelViewMatrix * vec4(first, 1.0), b = modelViewMatrix * vec4(second, 1.0);
      // Clips the part behind the camera.
      if (a.z > -near && b.z < -near) a = mix(a, b, (a.z + near) / (a.z - b.z));
      if (b.z > -near && a.z < -near) b = mix(b, a, (b.z + near) / (b.z - a.z));
      // Paler with distance, which makes a dense network readable.
      float far_share = clamp((-(position.x < 0.5 ? a : b).z - depth.x) / (depth.y - depth.x), 0.0, 1.0);
      // Moved a little towards the camera, so that springs on a surface are not half hidden in it.
      a = projectionMatrix * vec4(0.996 * a.xyz, 1.0);
      b = projectionMatrix * vec4(0.996 * b.xyz, 1.0);
      vec2 span = (b.xy / b.w - a.xy / a.w) * 0.5 * pixels;
      float extent = length(span);
      vec2 ahead = extent > 0.0 ? span / extent : vec2(1.0, 0.0);
      vec4 place = position.x < 0.5 ? a : b;
      place.xy += vec2(-ahead.y, ahead.x) * position.y * width / pixels * place.w;
      gl_Position = place;
      colour = mix(tint, vec3(0.96), 0.6 * far_share * far_share);
      side = position.y;
      along = position.x * extent;
    }`;
  const fragment = `
    precision mediump float;
    uniform float opacity, dash;
    varying vec3 colour;
    varying float side, along;
    void main() {
      if (dash > 0.0 && mod(along, 2.0 * dash) > dash) discard;
      gl_FragColor = vec4(colour * (0.62 + 0.38 * sqrt(max(0.0, 1.0 - side * side))), opacity);
    }`;

  // Per frame: begin(), add() for each line, end(). `capacity`: the most lines of a frame.
  s.Segments = function (capacity, options) {
    const first = new Float32Array(3 * capacity), second = new Float32Array(3 * capacity), tints = new Uint8Array(3 * capacity);
    const geometry = new THREE.InstancedBufferGeometry();
    const corners = [0, -1, 0, 1, -1, 0, 1, 1, 0, 0, -1, 0, 1, 1, 0, 0, 1, 0];
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(corners), 3));
    const attributes = [
      new THREE.InstancedBufferAttribute(first, 3), new THREE.InstancedBufferAttribute(second, 3),
      new THREE.InstancedBufferAttribute(tints, 3, true)];
    ["first", "second", "tint"].forEach(function (name, k) {
      attributes[k].setUsage(THREE.DynamicDrawUsage);
      geometry.setAttribute(name, attributes[k]);
    });
    const material = new THREE.ShaderMaterial({
      vertexShader: vertex, fragmentShader: fragment, side: THREE.DoubleSide,
      transparent: (options.opacity || 1) < 1, depthTest: !options.above,
      uniforms: {
        pixels: { value: new THREE.Vector2(1, 1) }, width: { value: options.width }, near: { value: s.camera.camera.near },
        depth: { value: s.camera.depth },
        opacity: { value: options.opacity || 1 }, dash: { value: options.dash || 0 }
      }
    });
    const mesh = new THREE.Mesh(geometry, material);
    mesh.frustumCulled = false;
    mesh.renderOrder = options.above ? 5 : 0;
    let count = 0;
    this.mesh = mesh;
    // The size of the picture in device pixels, and device pixels per unit of the given widths.
    this.resize = function (width, height, thickness) {
      material.uniforms.pixels.value.set(width, height);
      material.uniforms.width.value = options.width * thickness;
      material.uniforms.dash.value = (options.dash || 0) * thickness;
    };
    this.begin = function () { count = 0; };
    this.add = function (positions, a, b, table, offset) {
      const k = 3 * count++;
      for (let c = 0; c < 3; ++c) {
        first[k + c] = positions[3 * a + c];
        second[k + c] = positions[3 * b + c];
        tints[k + c] = table[offset + c];
      }
    };
    this.end = function () {
      geometry.maxInstancedCount = count;
      mesh.visible = count > 0;
      attributes.forEach(function (attribute) { attribute.needsUpdate = true; });
    };
  };

  const dot_vertex = `
    attribute vec3 tint;
    attribute float size;
    uniform float ratio;
    varying vec3 colour;
    varying float pixel;
    void main() {
      vec4 place = modelViewMatrix * vec4(position, 1.0);
      gl_Position = projectionMatrix * vec4(0.994 * place.xyz, 1.0);  // before the ends of the springs
      gl_PointSize = size * ratio;
      pixel = 2.0 / gl_PointSize;
      colour = tint;
    }`;
  const dot_fragment = `
    precision mediump float;
    uniform float hollow;
    varying vec3 colour;
    varying float pixel;
    void main() {
      float r = 2.0 * length(gl_PointCoord - 0.5);
      if (r > 1.0 || r < hollow) discard;
      gl_FragColor = vec4(colour * (hollow > 0.0 ? 1.0 : 1.0 - 0.35 * r * r), 1.0 - smoothstep(1.0 - pixel, 1.0, r));
    }`;
  // Round dots, `sizes` in pixels. `hollow`: rings, with this ratio of inner to outer radius.
  s.Dots = function (count, hollow) {
    this.positions = new Float32Array(3 * count);
    this.tints = new Uint8Array(3 * count);
    this.sizes = new Float32Array(count);
    const geometry = new THREE.BufferGeometry();
    const attributes = [new THREE.BufferAttribute(this.positions, 3), new THREE.BufferAttribute(this.tints, 3, true),
                        new THREE.BufferAttribute(this.sizes, 1)];
    ["position", "tint", "size"].forEach(function (name, k) { geometry.setAttribute(name, attributes[k]); });
    const material = new THREE.ShaderMaterial({
      vertexShader: dot_vertex, fragmentShader: dot_fragment, depthTest: !hollow, transparent: true,
      uniforms: { ratio: { value: 1 }, hollow: { value: hollow || 0 } }
    });
    this.mesh = new THREE.Points(geometry, material);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = hollow ? 6 : 1;
    this.resize = function (width, height, thickness) { material.uniforms.ratio.value = thickness; };
    this.update = function () { attributes.forEach(function (attribute) { attribute.needsUpdate = true; }); };
  };
})(springnet);
