'use strict';
(function () {
  // ---- Data -----------------------------------------------------------------

  const data = JSON.parse(document.getElementById('data').textContent);
  const byId = (id) => document.getElementById(id);

  function decode(text, Type) {
    const raw = atob(text || '');
    const bytes = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; ++i) bytes[i] = raw.charCodeAt(i);
    return new Type(bytes.buffer);
  }

  const OBSERVED = 2, INFERRED = 1, MISSING = 0;
  const NO_VALUE = 65535, NO_WEIGHT = 255, NO_ANGLE = -32768;
  // A robust loss never weighs a joint with nothing: less than a tenth (of 200).
  const REJECTED = 20;
  const frameNumbers = decode(data.frames, Int32Array);
  const times = decode(data.times, Float64Array);
  const frameCount = frameNumbers.length;
  const viewCount = data.detections ? data.cameras.length : 0;
  // Okabe and Ito's colours (but yellow and black, which one of the themes would
  // hide), and two that are farthest from them for any kind of colour vision.
  const PALETTE = ['#0072b2', '#e69f00', '#009e73', '#d55e00', '#56b4e9', '#cc79a7', '#8833ff', '#774422'];

  function loadResult(source, index) {
    const result = {
      index: index, label: source.label, truth: source.role === 'truth', mode: source.mode,
      ids: source.ids, colours: source.colours, joints: source.skeleton.joints, bones: source.skeleton.bones,
      frame: decode(source.frame, Uint32Array), person: decode(source.person, Uint16Array),
      status: decode(source.status, Uint8Array),
      residual: source.residual ? decode(source.residual, Uint16Array) : null,
      difference: source.difference ? decode(source.difference, Uint16Array) : null,
      match: source.match ? decode(source.match, Int16Array) : null,
      weight: source.weight ? decode(source.weight, Uint8Array) : null,
      covariance: source.covariance ? decode(source.covariance, Int16Array) : null,
      rootQuantum: source.rootQuantum, visible: true,
      names: source.names || {}, edits: source.edits || [], lines: source.identityLines || [],
      angles: source.angles || null
    };
    const root = decode(source.root, Int32Array), offset = decode(source.joints, Int16Array);
    const count = result.frame.length, J = result.joints.length;
    result.xyz = new Float32Array(count * J * 3);
    for (let p = 0; p < count; ++p) {
      for (let i = 0; i < J * 3; ++i) {
        result.xyz[p * J * 3 + i] = root[p * 3 + i % 3] * source.rootQuantum + offset[p * J * 3 + i] * source.quantum;
      }
    }
    // Poses of a frame lie together: start[f] to start[f + 1].
    result.start = new Uint32Array(frameCount + 1);
    for (let p = 0; p < count; ++p) result.start[result.frame[p] + 1]++;
    for (let f = 0; f < frameCount; ++f) result.start[f + 1] += result.start[f];
    // Extras are stored for some poses only.
    result.extra = new Int32Array(count);
    let stored = 0;
    for (let p = 0; p < count; ++p) {
      result.extra[p] = result.frame[p] % data.extrasStride === 0 ? stored++ : -1;
    }
    result.ofPerson = result.ids.map(() => []);
    for (let p = 0; p < count; ++p) result.ofPerson[result.person[p]].push(p);
    return result;
  }

  const results = data.results.map(loadResult);

  function loadDetections(source) {
    if (!source) return null;
    const counts = decode(source.counts, Uint16Array);
    const start = new Uint32Array(counts.length + 1);
    for (let i = 0; i < counts.length; ++i) start[i + 1] = start[i] + counts[i];
    return {
      joints: source.skeleton.joints, bones: source.skeleton.bones, quantum: source.quantum, start: start,
      xy: decode(source.xy, Uint16Array), confidence: decode(source.confidence, Uint8Array)
    };
  }
  const detections = loadDetections(data.detections);

  function colourOf(result, person) {
    if (result.truth) return dark() ? '#d5dce5' : '#333b46';
    return PALETTE[result.colours[person] % PALETTE.length];
  }

  function nameOf(result, person) {
    const id = result.ids[person];
    return (result.truth ? 'truth ' : '') + (Object.prototype.hasOwnProperty.call(result.names, id) ? result.names[id] : id);
  }

  function dark() { return document.documentElement.classList.contains('dark'); }

  function element(tag, properties, children) {
    const node = Object.assign(document.createElement(tag), properties || {});
    (children || []).forEach((child) => node.append(child));
    return node;
  }

  // ---- 3D scene -------------------------------------------------------------

  const up = new THREE.Vector3().fromArray(data.up);
  const scratch = {
    a: new THREE.Vector3(), b: new THREE.Vector3(), direction: new THREE.Vector3(),
    matrix: new THREE.Matrix4(), turn: new THREE.Quaternion(), scale: new THREE.Vector3(), y: new THREE.Vector3(0, 1, 0)
  };

  function extent() {
    const box = new THREE.Box3();
    results.forEach((result) => {
      const J = result.joints.length;
      const step = Math.max(1, Math.floor(result.frame.length / 3000));
      for (let p = 0; p < result.frame.length; p += step) {
        for (let j = 0; j < J; ++j) {
          if ((result.status[p * J + j] & 3) === MISSING) continue;
          box.expandByPoint(scratch.a.fromArray(result.xyz, (p * J + j) * 3));
        }
      }
    });
    if (box.isEmpty()) box.set(new THREE.Vector3(-1, -1, -1), new THREE.Vector3(1, 1, 1));
    return box;
  }
  const people = extent();
  const middle = people.getCenter(new THREE.Vector3());
  const reach = Math.min(30, Math.max(2, people.getSize(new THREE.Vector3()).length() / 2));

  class Scene {
    constructor(canvas) {
      this.canvas = canvas;
      const context = canvas.getContext('webgl2', { antialias: true, alpha: true });
      if (!context) throw new Error('no WebGL 2');
      this.renderer = new THREE.WebGLRenderer({ canvas: canvas, context: context, antialias: true, alpha: true });
      this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
      this.scene = new THREE.Scene();
      this.camera = new THREE.PerspectiveCamera(45, 1, 0.05, 500);
      this.camera.up.copy(up);
      this.controls = new THREE.OrbitControls(this.camera, canvas);
      this.controls.enableKeys = false;
      this.controls.addEventListener('change', () => { this.dirty = true; });
      this.scene.add(new THREE.AmbientLight(0xffffff, 0.65));
      this.light = new THREE.DirectionalLight(0xffffff, 0.55);
      this.scene.add(this.light);
      this.ball = new THREE.IcosahedronBufferGeometry(1, 2);
      this.gem = new THREE.OctahedronBufferGeometry(1, 0);
      this.rod = new THREE.CylinderBufferGeometry(1, 1, 1, 8, 1, true);
      this.bodies = results.map(() => []);
      this.frusta = [];
      this.cameraLines = [];
      this.addFloor();
      this.addCameras();
      this.home();
      this.dirty = true;
    }

    home() {
      const right = new THREE.Vector3(1, 0, 0);
      if (Math.abs(up.x) > 0.9) right.set(0, 1, 0);
      const forward = new THREE.Vector3().crossVectors(up, right).normalize();
      right.crossVectors(forward, up).normalize();
      // From the cameras' side when there are cameras, else from the front.
      const away = new THREE.Vector3();
      data.cameras.forEach((camera) => away.add(scratch.a.fromArray(camera.centre).sub(middle)));
      away.addScaledVector(up, -away.dot(up));
      if (away.length() < 0.3) away.copy(right).addScaledVector(forward, 0.6);
      away.normalize();
      this.controls.target.copy(middle);
      this.camera.position.copy(middle).addScaledVector(away, reach * 1.9).addScaledVector(up, reach * 1.05);
      this.controls.update();
    }

    addFloor() {
      const size = Math.ceil(reach * 1.6) * 2;
      this.floor = new THREE.GridHelper(size, size, 0x8090a0, 0x8090a0);
      this.floor.material.transparent = true;
      this.floor.material.opacity = 0.32;
      this.floor.material.depthWrite = false;
      this.floor.quaternion.setFromUnitVectors(scratch.y, up);
      this.floor.position.copy(middle).addScaledVector(up, data.floor - middle.dot(up));
      this.scene.add(this.floor);
    }

    addCameras() {
      this.cameraGroup = new THREE.Group();
      this.cameraMaterial = new THREE.LineBasicMaterial({ color: 0x7b8794 });
      const depth = Math.min(0.6, reach * 0.12);
      data.cameras.forEach((camera) => {
        const width = camera.width || 2 * camera.K[2], height = camera.height || 2 * camera.K[5];
        const corner = (u, v) => {
          const x = (u - camera.K[2]) / camera.K[0] * depth, y = (v - camera.K[5]) / camera.K[4] * depth;
          const c = [x - camera.t[0], y - camera.t[1], depth - camera.t[2]], R = camera.R;
          return new THREE.Vector3(R[0] * c[0] + R[3] * c[1] + R[6] * c[2], R[1] * c[0] + R[4] * c[1] + R[7] * c[2], R[2] * c[0] + R[5] * c[1] + R[8] * c[2]);
        };
        const apex = new THREE.Vector3().fromArray(camera.centre);
        const corners = [corner(0, 0), corner(width, 0), corner(width, height), corner(0, height)];
        const points = [];
        corners.forEach((c, i) => {
          points.push(apex, c, c, corners[(i + 1) % 4]);
          this.cameraLines.push([apex, c], [c, corners[(i + 1) % 4]]);
        });
        this.cameraGroup.add(new THREE.LineSegments(new THREE.BufferGeometry().setFromPoints(points), this.cameraMaterial));
        this.frusta.push(apex);
      });
      this.scene.add(this.cameraGroup);
    }

    // Meshes of one person: joints and bones, observed and inferred apart.
    body(result, person) {
      const made = this.bodies[result.index];
      if (made[person]) return made[person];
      const solid = new THREE.MeshLambertMaterial({ color: colourOf(result, person) });
      const faint = new THREE.MeshLambertMaterial({ color: colourOf(result, person), transparent: true, opacity: 0.3, depthWrite: false });
      const shape = result.index === 0 ? this.ball : this.gem;
      const mesh = (geometry, material, count) => {
        const instanced = new THREE.InstancedMesh(geometry, material, Math.max(1, count));
        instanced.frustumCulled = false;
        this.scene.add(instanced);
        return instanced;
      };
      const J = result.joints.length, B = result.bones.length;
      const body = {
        solid: solid, faint: faint,
        joints: mesh(shape, solid, J), inferredJoints: mesh(shape, faint, J),
        bones: mesh(this.rod, solid, B), inferredBones: mesh(this.rod, faint, B), ellipsoids: null
      };
      const trail = new THREE.BufferGeometry();
      trail.setAttribute('position', new THREE.BufferAttribute(new Float32Array(3 * TRAIL_POINTS), 3));
      body.trailMaterial = new THREE.LineBasicMaterial({ color: colourOf(result, person), transparent: true, opacity: 0.7 });
      body.trail = new THREE.Line(trail, body.trailMaterial);
      body.trail.frustumCulled = false;
      this.scene.add(body.trail);
      body.meshes = [body.joints, body.inferredJoints, body.bones, body.inferredBones];
      made[person] = body;
      return body;
    }

    hideBody(body) {
      body.meshes.forEach((mesh) => { mesh.visible = false; });
      body.trail.visible = false;
      if (body.ellipsoids) body.ellipsoids.visible = false;
    }

    poseBody(result, p) {
      const body = this.body(result, result.person[p]);
      const J = result.joints.length, xyz = result.xyz, base = p * J;
      const thickness = result.index === 0 ? 1 : 0.45;
      let observed = 0, inferred = 0;
      for (let j = 0; j < J; ++j) {
        const status = result.status[base + j] & 3;
        if (status === MISSING) continue;
        const size = (result.index === 0 ? 0.032 : 0.026) * (status === INFERRED ? 0.8 : 1);
        scratch.matrix.makeScale(size, size, size).setPosition(xyz[(base + j) * 3], xyz[(base + j) * 3 + 1], xyz[(base + j) * 3 + 2]);
        if (status === OBSERVED) body.joints.setMatrixAt(observed++, scratch.matrix);
        else body.inferredJoints.setMatrixAt(inferred++, scratch.matrix);
      }
      body.joints.count = observed;
      body.inferredJoints.count = inferred;
      observed = inferred = 0;
      for (const [a, b] of result.bones) {
        const status = Math.min(result.status[base + a] & 3, result.status[base + b] & 3);
        if (status === MISSING) continue;
        scratch.a.fromArray(xyz, (base + a) * 3);
        scratch.b.fromArray(xyz, (base + b) * 3);
        const length = scratch.direction.subVectors(scratch.b, scratch.a).length();
        if (length < 1e-6) continue;
        scratch.turn.setFromUnitVectors(scratch.y, scratch.direction.divideScalar(length));
        scratch.a.add(scratch.b).multiplyScalar(0.5);
        scratch.matrix.compose(scratch.a, scratch.turn, scratch.scale.set(0.019 * thickness, length, 0.019 * thickness));
        if (status === OBSERVED) body.bones.setMatrixAt(observed++, scratch.matrix);
        else body.inferredBones.setMatrixAt(inferred++, scratch.matrix);
      }
      body.bones.count = observed;
      body.inferredBones.count = inferred;
      body.meshes.forEach((mesh) => { mesh.visible = mesh.count > 0; mesh.instanceMatrix.needsUpdate = true; });
      this.poseTrail(result, p, body);
      this.poseEllipsoids(result, p, body);
    }

    poseTrail(result, p, body) {
      body.trail.visible = show.trails;
      if (!show.trails) return;
      const history = result.ofPerson[result.person[p]];
      const position = body.trail.geometry.attributes.position;
      let at = lowerBound(history, p), count = 0;
      const last = times[result.frame[p]];
      for (; at >= 0 && count < TRAIL_POINTS && last - times[result.frame[history[at]]] < TRAIL_SECONDS; --at) {
        const c = footOf(result, history[at]);
        if (!c) continue;
        position.array.set(c, 3 * count++);
      }
      body.trail.geometry.setDrawRange(0, count);
      position.needsUpdate = true;
    }

    poseEllipsoids(result, p, body) {
      const wanted = show.ellipsoids && result.covariance && result.extra[p] >= 0;
      if (!wanted) {
        if (body.ellipsoids) body.ellipsoids.visible = false;
        return;
      }
      const J = result.joints.length;
      if (!body.ellipsoids) {
        const material = new THREE.MeshLambertMaterial({ color: colourOf(result, result.person[p]), transparent: true, opacity: 0.28, depthWrite: false });
        body.ellipsoids = new THREE.InstancedMesh(this.ball, material, J);
        body.ellipsoids.frustumCulled = false;
        this.scene.add(body.ellipsoids);
      }
      let count = 0;
      for (let j = 0; j < J; ++j) {
        if ((result.status[p * J + j] & 3) === MISSING) continue;
        const at = (result.extra[p] * J + j) * 6, L = result.covariance, k = 2 * result.rootQuantum;
        if (L[at] === 0 && L[at + 2] === 0) continue;
        const x = (p * J + j) * 3;
        scratch.matrix.set(
          k * L[at], 0, 0, result.xyz[x],
          k * L[at + 1], k * L[at + 2], 0, result.xyz[x + 1],
          k * L[at + 3], k * L[at + 4], k * L[at + 5], result.xyz[x + 2], 0, 0, 0, 1);
        body.ellipsoids.setMatrixAt(count++, scratch.matrix);
      }
      body.ellipsoids.count = count;
      body.ellipsoids.visible = count > 0;
      body.ellipsoids.instanceMatrix.needsUpdate = true;
    }

    setFrame(f) {
      this.bodies.forEach((made) => made.forEach((body) => body && this.hideBody(body)));
      results.forEach((result) => {
        if (!result.visible) return;
        for (let p = result.start[f]; p < result.start[f + 1]; ++p) this.poseBody(result, p);
      });
      this.floor.visible = show.floor;
      this.cameraGroup.visible = show.cameras;
      this.dirty = true;
    }

    recolour() {
      this.bodies.forEach((made, r) => made.forEach((body, person) => {
        if (!body) return;
        const colour = colourOf(results[r], person);
        [body.solid, body.faint, body.trailMaterial].forEach((material) => material.color.set(colour));
      }));
      this.dirty = true;
    }

    resize() {
      // Kept, so that no picture has to ask the browser for a layout.
      this.width = this.canvas.parentElement.clientWidth;
      this.height = this.canvas.parentElement.clientHeight;
      this.renderer.setSize(this.width, this.height, false);
      this.camera.aspect = this.width / Math.max(1, this.height);
      this.camera.updateProjectionMatrix();
      this.dirty = true;
    }

    render() {
      if (!this.dirty) return;
      this.dirty = false;
      this.light.position.copy(this.camera.position).addScaledVector(up, reach);
      this.renderer.render(this.scene, this.camera);
      placeLabels(this);
    }
  }

  const TRAIL_POINTS = 128, TRAIL_SECONDS = 2;
  const show = { trails: true, labels: true, cameras: true, floor: true, ellipsoids: false };

  // Largest index whose value is not above `value`.
  function lowerBound(list, value) {
    let low = 0, high = list.length - 1;
    while (low < high) {
      const mid = (low + high + 1) >> 1;
      if (list[mid] <= value) low = mid; else high = mid - 1;
    }
    return low;
  }

  // Where a person stands: the mean of the joints, dropped to the floor.
  const footBuffer = [0, 0, 0];
  function footOf(result, p) {
    const J = result.joints.length;
    let x = 0, y = 0, z = 0, n = 0;
    for (let j = 0; j < J; ++j) {
      if ((result.status[p * J + j] & 3) === MISSING) continue;
      const at = (p * J + j) * 3;
      x += result.xyz[at]; y += result.xyz[at + 1]; z += result.xyz[at + 2];
      ++n;
    }
    if (n === 0) return null;
    x /= n; y /= n; z /= n;
    const drop = data.floor + 0.01 - (x * up.x + y * up.y + z * up.z);
    footBuffer[0] = x + drop * up.x; footBuffer[1] = y + drop * up.y; footBuffer[2] = z + drop * up.z;
    return footBuffer;
  }

  // ---- Labels over the 3D view ------------------------------------------------

  const labelPool = [];
  function placeLabels(view) {
    let used = 0;
    const width = view.width, height = view.height;
    const put = (point, text, colour, className) => {
      scratch.b.copy(point).project(view.camera);
      if (scratch.b.z > 1 || Math.abs(scratch.b.x) > 1 || Math.abs(scratch.b.y) > 1) return;
      if (!labelPool[used]) labelPool.push(byId('labels').appendChild(document.createElement('span')));
      const label = labelPool[used++];
      if (label.textContent !== text) label.textContent = text;
      label.className = className;
      label.style.borderColor = colour || 'transparent';
      label.style.transform = 'translate(-50%, -100%) translate(' + ((scratch.b.x + 1) / 2 * width).toFixed(1) + 'px,' + ((1 - scratch.b.y) / 2 * height).toFixed(1) + 'px)';
      label.hidden = false;
    };
    if (show.labels) {
      if (show.cameras) data.cameras.forEach((camera, c) => put(view.frusta[c], camera.view, '', 'camera'));
      const result = results.find((r) => r.visible);
      if (result) {
        for (let p = result.start[state.frame]; p < result.start[state.frame + 1]; ++p) {
          put(headOf(result, p), nameOf(result, result.person[p]), colourOf(result, result.person[p]), '');
        }
      }
    }
    for (let i = used; i < labelPool.length; ++i) labelPool[i].hidden = true;
  }

  function headOf(result, p) {
    const J = result.joints.length;
    let best = -Infinity;
    for (let j = 0; j < J; ++j) {
      if ((result.status[p * J + j] & 3) === MISSING) continue;
      scratch.b.fromArray(result.xyz, (p * J + j) * 3);
      const height = scratch.b.dot(up);
      if (height > best) { best = height; scratch.a.copy(scratch.b); }
    }
    return scratch.a.addScaledVector(up, 0.14);
  }

  // ---- Camera panels ----------------------------------------------------------

  function lensLimit(k) {
    // First squared radius where the radial polynomial turns back.
    for (let s = 0; s < 25; s += 0.01) {
      if (1 + 3 * k[0] * s + 5 * k[1] * s * s + 7 * k[4] * s * s * s <= 0) return s;
    }
    return Infinity;
  }

  function project(camera, x, y, z) {
    const R = camera.R, t = camera.t, K = camera.K;
    const depth = R[6] * x + R[7] * y + R[8] * z + t[2];
    if (depth <= 1e-6) return null;
    let u = (R[0] * x + R[1] * y + R[2] * z + t[0]) / depth, v = (R[3] * x + R[4] * y + R[5] * z + t[1]) / depth;
    if (camera.model === 'opencv5') {
      const k = camera.distortion, s = u * u + v * v;
      if (camera.limit === undefined) camera.limit = lensLimit(k);
      if (s >= camera.limit) return null;
      const radial = 1 + s * (k[0] + s * (k[1] + s * k[4]));
      const du = u * radial + 2 * k[2] * u * v + k[3] * (s + 2 * u * u);
      v = v * radial + k[2] * (s + 2 * v * v) + 2 * k[3] * u * v;
      u = du;
    }
    return [K[0] * u + K[1] * v + K[2], K[4] * v + K[5]];
  }

  const panels = [];
  function makePanels() {
    if (data.cameras.length === 0) return;
    byId('views').hidden = false;
    byId('view-legend').textContent = detections
      ? 'Thin: detections (circles are joints that were found; dashed means matched to nobody). Thick: 3D poses seen by the camera. '
        + 'Cross: joint that the joints filter rejected or the loss weighs with less than a tenth. Square: joint that the detector did not find. '
        + (results.some((r) => r.match && hasWeights(r)) ? '' : 'The tracks name no matches: each person is paired with the nearest detection.')
      : 'The 3D poses as each camera would see them.';
    data.cameras.forEach((camera, v) => {
      const canvas = element('canvas');
      const width = camera.width || 2 * camera.K[2], height = camera.height || 2 * camera.K[5];
      const facts = element('span');
      byId('panels').append(element('figure', {}, [canvas, element('figcaption', {}, [element('b', { textContent: camera.view }), facts])]));
      panels.push({ camera: camera, view: v, canvas: canvas, facts: facts, width: width, height: height, seen: true, pictures: new Map(), lacks: '' });
    });
    panels.forEach(openVideo);
    if ('IntersectionObserver' in window) {
      const observer = new IntersectionObserver((entries) => entries.forEach((entry) => {
        const panel = panels.find((one) => one.canvas === entry.target);
        panel.seen = entry.isIntersecting;
        if (panel.seen) drawPanel(panel, state.frame);
        else if (panel.video) panel.video.node.pause();
      }));
      panels.forEach((panel) => observer.observe(panel.canvas));
    }
  }

  function hasWeights(result) { return result.weight.some((w) => w !== NO_WEIGHT); }

  // As many in a row as have room, and as even as can be: five are 5, 3 + 2 or
  // 2 + 2 + 1; what is left of a row its panels share.
  function arrangePanels() {
    const width = byId('panels').clientWidth || 300;
    const most = Math.max(1, Math.min(5, Math.floor((width + 10) / 260)));
    const rows = Math.ceil(panels.length / most);
    byId('panels').style.setProperty('--in-row', String(Math.ceil(panels.length / Math.max(1, rows))));
  }

  function sizePanels() {
    arrangePanels();
    panels.forEach((panel) => {
      const width = panel.canvas.clientWidth || 300, ratio = Math.min(2, window.devicePixelRatio || 1);
      panel.canvas.width = Math.round(width * ratio);
      panel.canvas.height = Math.round(width * ratio * panel.height / panel.width);
      panel.scale = panel.canvas.width / panel.width;
      panel.unit = ratio;
    });
  }

  // ---- Pictures behind the panels ------------------------------------------------

  const KEPT_PICTURES = 24, AHEAD = 6;

  function pictureUrl(pattern, number) {
    return fileUrl(pattern.replace(/%0?(\d*)d/, (all, width) => String(number).padStart(Number(width) || 0, '0')));
  }

  function fileUrl(path) { return path.split('/').map(encodeURIComponent).join('/'); }

  // Where the picture of a frame is: inside of the page, where the latest one
  // stands for those that were left out, or beside it.
  function pictureSource(panel, f) {
    const inside = panel.camera.pictures;
    if (!inside) return panel.camera.images ? pictureUrl(panel.camera.images, frameNumbers[f]) : undefined;
    const at = lowerBound(inside.at, f);
    if (inside.at[at] > f) return undefined;
    return 'data:image/jpeg;base64,' + inside.jpeg[at];
  }

  // The picture of a frame, or undefined where there is none.
  function pictureOf(panel, f) {
    if (f >= frameCount) return undefined;
    let picture = panel.pictures.get(f);
    if (picture) return picture;
    const source = pictureSource(panel, f);
    if (!source) return undefined;
    picture = new Image();
    picture.onload = picture.onerror = () => { if (state.frame === f && panel.seen) drawPanel(panel, f); };
    picture.src = source;
    panel.pictures.set(f, picture);
    if (panel.pictures.size > KEPT_PICTURES) panel.pictures.delete(panel.pictures.keys().next().value);
    return picture;
  }

  function drawPicture(pen, panel, f) {
    const shown = panel.video ? videoOf(panel, f) : stillOf(panel, f);
    if (!shown) return;
    pen.drawImage(shown, 0, 0, panel.width, panel.height);
    // Lines must be seen on it.
    pen.fillStyle = dark() ? 'rgba(13,17,22,.35)' : 'rgba(255,255,255,.35)';
    pen.fillRect(0, 0, panel.width, panel.height);
  }

  function stillOf(panel, f) {
    const picture = pictureOf(panel, f);
    if (state.playing) for (let ahead = 1; ahead <= AHEAD; ++ahead) pictureOf(panel, f + ahead);
    if (!picture || !picture.complete) return undefined;
    if (picture.naturalWidth === 0) { panel.lacks = 'no picture of this frame'; return undefined; }
    return picture;
  }

  // ---- Videos behind the panels --------------------------------------------------

  // Far apart a playing video is sent to its place; nearer it plays faster or
  // slower until it is there [s].
  const FAR_APART = 0.3;

  function openVideo(panel) {
    const source = panel.camera.video;
    if (!source) return;
    const node = element('video', { muted: true, playsInline: true, preload: 'auto' });
    panel.video = { node: node, at: decode(source.at, Float64Array), sought: NaN };
    const redraw = () => { if (panel.seen) drawPanel(panel, state.frame); };
    ['loadedmetadata', 'loadeddata', 'seeked', 'error'].forEach((name) => node.addEventListener(name, redraw));
    node.src = source.data ? URL.createObjectURL(new Blob([decode(source.data, Uint8Array)], { type: source.type })) : fileUrl(source.source);
  }

  // The video with the picture of the frame; while it is on its way there, with
  // the one before.
  function videoOf(panel, f) {
    const node = panel.video.node;
    if (node.error) { panel.lacks = 'this browser does not play the video'; return undefined; }
    if (panel.video.at[f] < 0) { node.pause(); panel.lacks = 'no picture of this frame'; return undefined; }
    if (node.readyState < 1) return undefined;
    if (state.playing) playAlong(panel.video, f);
    else seekVideo(panel.video, f);
    return node.readyState < 2 ? undefined : node;
  }

  // Once for each place, or a video that ends early would be sought for ever.
  function seekVideo(video, f) {
    video.node.pause();
    const there = Math.abs(video.node.currentTime - video.at[f]) < 1e-3;
    if (there || video.node.seeking || video.sought === video.at[f]) return;
    video.sought = video.at[f];
    video.node.currentTime = video.at[f];
  }

  function playAlong(video, f) {
    const node = video.node, next = f + 1;
    const known = next < frameCount && video.at[next] >= 0 && times[next] > times[f];
    // Seconds of video in one of the page, as their frames stand to one another.
    const slope = known ? (video.at[next] - video.at[f]) / (times[next] - times[f]) : 1;
    const behind = video.at[f] + (state.time - times[f]) * slope - node.currentTime;
    video.sought = NaN;
    if (Math.abs(behind) > FAR_APART && !node.seeking) node.currentTime += behind;
    const rate = state.speed * slope * (1 + Math.max(-0.5, Math.min(0.5, 3 * behind)));
    node.playbackRate = Math.max(0.0625, Math.min(16, rate));
    if (node.paused) node.play().catch(() => {});
  }

  // Who a detection of this view and frame belongs to.
  function ownersIn(view, f) {
    const owners = new Map();
    results.slice().reverse().forEach((result) => {
      if (!result.match || !result.visible) return;
      for (let p = result.start[f]; p < result.start[f + 1]; ++p) {
        if (result.extra[p] < 0) continue;
        const d = result.match[result.extra[p] * viewCount + view];
        if (d >= 0) owners.set(d, { result: result, p: p });
      }
    });
    return owners;
  }

  function drawPanel(panel, f) {
    const pen = panel.canvas.getContext('2d');
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.clearRect(0, 0, panel.canvas.width, panel.canvas.height);
    pen.setTransform(panel.scale, 0, 0, panel.scale, 0, 0);
    const facts = paintPanel(pen, panel, f, panel.unit / panel.scale, true);
    panel.facts.textContent = facts + (panel.lacks ? (facts ? '; ' : '') + panel.lacks : '');
  }

  // In image pixels; `px` is one pixel of the screen. Returns what there is.
  function paintPanel(pen, panel, f, px, withPicture) {
    panel.lacks = '';
    if (withPicture) drawPicture(pen, panel, f);
    results.forEach((result) => { if (result.visible) drawReprojections(pen, panel, result, f, px); });
    return detections ? drawDetections(pen, panel, f, px) : '';
  }

  function drawReprojections(pen, panel, result, f, px) {
    const J = result.joints.length;
    pen.lineCap = 'round';
    pen.setLineDash([]);
    for (let p = result.start[f]; p < result.start[f + 1]; ++p) {
      const points = [];
      for (let j = 0; j < J; ++j) {
        const at = (p * J + j) * 3;
        points.push((result.status[p * J + j] & 3) === MISSING ? null : project(panel.camera, result.xyz[at], result.xyz[at + 1], result.xyz[at + 2]));
      }
      pen.strokeStyle = colourOf(result, result.person[p]);
      for (const [a, b] of result.bones) {
        if (!points[a] || !points[b]) continue;
        const inferred = Math.min(result.status[p * J + a] & 3, result.status[p * J + b] & 3) === INFERRED;
        pen.globalAlpha = inferred ? 0.35 : 0.8;
        pen.lineWidth = (result.index === 0 ? 4 : 1.8) * px;
        pen.beginPath();
        pen.moveTo(points[a][0], points[a][1]);
        pen.lineTo(points[b][0], points[b][1]);
        pen.stroke();
      }
    }
    pen.globalAlpha = 1;
  }

  function drawDetections(pen, panel, f, px) {
    if (f % data.extrasStride !== 0) return 'detections of this frame were left out to save space';
    const slot = f * viewCount + panel.view, D = detections.joints.length;
    const owners = ownersIn(panel.view, f);
    let matched = 0, rejected = 0, missing = 0;
    const ink = dark() ? '#e7ebf0' : '#1b2430', bad = dark() ? '#ff8f66' : '#b3330c';
    const total = detections.start[slot + 1] - detections.start[slot];
    for (let d = 0; d < total; ++d) {
      const base = (detections.start[slot] + d) * D, owner = owners.get(d);
      const at = (j) => [detections.xy[(base + j) * 2] * detections.quantum, detections.xy[(base + j) * 2 + 1] * detections.quantum];
      const found = (j) => detections.confidence[base + j] > 0;
      if (owner) ++matched;
      pen.strokeStyle = owner ? ink : (dark() ? '#9aa6b5' : '#5b6675');
      pen.lineWidth = 1.1 * px;
      pen.setLineDash(owner ? [] : [3 * px, 3 * px]);
      pen.beginPath();
      for (const [a, b] of detections.bones) {
        if (!found(a) || !found(b)) continue;
        pen.moveTo(...at(a));
        pen.lineTo(...at(b));
      }
      pen.stroke();
      pen.setLineDash([]);
      for (let j = 0; j < D; ++j) {
        const verdict = owner ? jointVerdict(owner, panel.view, j) : 'kept';
        if (!found(j)) {
          if (owner && drawMissing(pen, panel, owner, j, px, ink)) ++missing;
          continue;
        }
        const [x, y] = at(j);
        pen.beginPath();
        if (verdict === 'rejected') {
          ++rejected;
          pen.strokeStyle = bad;
          pen.lineWidth = 2 * px;
          const r = 4 * px;
          pen.moveTo(x - r, y - r); pen.lineTo(x + r, y + r); pen.moveTo(x - r, y + r); pen.lineTo(x + r, y - r);
        } else {
          pen.strokeStyle = owner ? ink : (dark() ? '#9aa6b5' : '#5b6675');
          pen.lineWidth = 1.1 * px;
          pen.arc(x, y, 2.2 * px, 0, 7);
        }
        pen.stroke();
      }
      drawOwner(pen, panel, owner, base, px);
    }
    return 'detections ' + total + ', matched ' + matched + '; joints rejected ' + rejected + ', not found ' + missing;
  }

  function drawOwner(pen, panel, owner, base, px) {
    if (!owner) return;
    let top = null;
    for (let j = 0; j < detections.joints.length; ++j) {
      if (!detections.confidence[base + j]) continue;
      const x = detections.xy[(base + j) * 2] * detections.quantum, y = detections.xy[(base + j) * 2 + 1] * detections.quantum;
      if (!top || y < top[1]) top = [x, y];
    }
    if (!top) return;
    // Its colour as a dot; the name itself has to be read on any colour.
    const x = top[0] + 5 * px, y = top[1] - 9 * px;
    const name = nameOf(owner.result, owner.result.person[owner.p]) + (owner.result.index > 0 ? ' (' + owner.result.label + ')' : '');
    pen.font = '600 ' + 12 * px + 'px system-ui, sans-serif';
    pen.lineWidth = 3 * px;
    pen.strokeStyle = dark() ? '#0d1116' : '#e9edf2';
    pen.fillStyle = dark() ? '#e7ebf0' : '#1b2430';
    pen.strokeText(name, x + 6 * px, y + 4 * px);
    pen.fillText(name, x + 6 * px, y + 4 * px);
    pen.fillStyle = colourOf(owner.result, owner.result.person[owner.p]);
    pen.beginPath();
    pen.arc(x, y, 3.5 * px, 0, 7);
    pen.fill();
  }

  function ownJoint(result, j) {
    if (!result.jointOf) result.jointOf = detections.joints.map((name) => result.joints.indexOf(name));
    return result.jointOf[j];
  }

  function jointVerdict(owner, view, j) {
    const own = ownJoint(owner.result, j), J = owner.result.joints.length;
    if (own < 0) return 'kept';
    return owner.result.weight[(owner.result.extra[owner.p] * viewCount + view) * J + own] < REJECTED ? 'rejected' : 'kept';
  }

  // A joint that the detector did not find, where the 3D pose puts it.
  function drawMissing(pen, panel, owner, j, px, ink) {
    const own = ownJoint(owner.result, j), J = owner.result.joints.length;
    if (own < 0 || (owner.result.status[owner.p * J + own] & 3) === MISSING) return false;
    const at = (owner.p * J + own) * 3, xyz = owner.result.xyz;
    const point = project(panel.camera, xyz[at], xyz[at + 1], xyz[at + 2]);
    if (!point) return false;
    pen.strokeStyle = ink;
    pen.lineWidth = px;
    pen.strokeRect(point[0] - 3 * px, point[1] - 3 * px, 6 * px, 6 * px);
    return true;
  }

  // ---- Series for the timelines -------------------------------------------------

  function jointDistance(result, p, q, j) {
    const J = result.joints.length, a = (p * J + j) * 3, b = (q * J + j) * 3, xyz = result.xyz;
    if ((result.status[p * J + j] & 3) === MISSING || (result.status[q * J + j] & 3) === MISSING) return NaN;
    return Math.hypot(xyz[a] - xyz[b], xyz[a + 1] - xyz[b + 1], xyz[a + 2] - xyz[b + 2]);
  }

  function perPerson(result, valueOf) {
    return result.ids.map((id, person) => {
      const values = new Float32Array(frameCount).fill(NaN);
      result.ofPerson[person].forEach((p, i) => { values[result.frame[p]] = valueOf(p, i, result.ofPerson[person]); });
      return { name: nameOf(result, person), colour: () => colourOf(result, person), values: values, thin: result.index > 0, source: result.label };
    });
  }

  function speedOf(result) {
    return (p, i, list) => {
      if (i === 0) return NaN;
      const q = list[i - 1], dt = times[result.frame[p]] - times[result.frame[q]];
      if (!(dt > 0) || dt > 0.25) return NaN;
      let sum = 0, n = 0;
      for (let j = 0; j < result.joints.length; ++j) {
        const distance = jointDistance(result, p, q, j);
        if (distance === distance) { sum += distance; ++n; }
      }
      return n ? sum / n / dt : NaN;
    };
  }

  function boneLengthOf(result, bone) {
    const J = result.joints.length, [a, b] = bone;
    return (p) => {
      if ((result.status[p * J + a] & 3) === MISSING || (result.status[p * J + b] & 3) === MISSING) return NaN;
      const x = (p * J + a) * 3, y = (p * J + b) * 3, xyz = result.xyz;
      return 100 * Math.hypot(xyz[x] - xyz[y], xyz[x + 1] - xyz[y + 1], xyz[x + 2] - xyz[y + 2]);
    };
  }

  function meanViews(result, p) {
    const J = result.joints.length;
    let sum = 0, n = 0;
    for (let j = 0; j < J; ++j) {
      if ((result.status[p * J + j] & 3) !== MISSING) { sum += result.status[p * J + j] >> 2; ++n; }
    }
    return n ? sum / n : 0;
  }

  function residualSeries(result) {
    return data.cameras.map((camera, v) => {
      const values = new Float32Array(frameCount).fill(NaN);
      for (let f = 0; f < frameCount; ++f) {
        let sum = 0, n = 0;
        for (let p = result.start[f]; p < result.start[f + 1]; ++p) {
          const value = result.residual[p * viewCount + v];
          if (value !== NO_VALUE) { sum += value * 0.1; ++n; }
        }
        if (n) values[f] = sum / n;
      }
      return { name: camera.view, colour: () => PALETTE[v % PALETTE.length], values: values, thin: false };
    });
  }

  // ---- Charts ---------------------------------------------------------------------

  // Width left of a plot for names and for the axis' numbers.
  function gutter() { return window.innerWidth < 760 ? 58 : 110; }

  // A number as people write it: three digits at most, no exponent.
  function human(value) {
    const size = Math.abs(value);
    if (size >= 100 || Number.isInteger(value)) return String(Math.round(value));
    return value.toFixed(size >= 10 ? 0 : size >= 1 ? 1 : 2);
  }

  // "left ankle" of "l_ankle".
  function jointName(name) {
    return name.replace(/\b([lr])_/g, (all, side) => (side === 'l' ? 'left ' : 'right ')).replace(/_/g, ' ');
  }

  const AXIS = 16;  // px under a plot, for times

  // First and last time, and a few round ones in between.
  function drawTimeAxis(pen, width, height) {
    const first = times[0], last = times[frameCount - 1], span = last - first;
    pen.fillStyle = dark() ? '#9aa6b5' : '#5b6675';
    pen.font = '11px system-ui, sans-serif';
    pen.fillRect(0, height, width, 1);
    const digits = span < 20 ? 1 : 0;
    const text = (time) => time.toFixed(digits) + ' s';
    pen.textAlign = 'left';
    pen.fillText(text(first), 0, height + AXIS - 3);
    pen.textAlign = 'right';
    pen.fillText(text(last), width, height + AXIS - 3);
    pen.textAlign = 'center';
    if (!(span > 0)) return;
    let step = Math.pow(10, Math.floor(Math.log10(span / 3)));
    while (span / step > width / 90) step *= 2;
    for (let time = Math.ceil(first / step) * step; time < last; time += step) {
      const x = (time - first) / span * width;
      if (x < 70 || x > width - 70) continue;
      pen.fillRect(x, height - 3, 1, 4);
      pen.fillText(text(time), x, height + AXIS - 3);
    }
    pen.textAlign = 'left';
  }

  const charts = [];
  class Chart {
    constructor(title, height, draw) {
      this.head = element('div', { className: 'head' }, [element('b', { textContent: title })]);
      this.canvas = element('canvas');
      this.cursor = element('div', { className: 'cursor' });
      this.plot = element('div', { className: 'plot' }, [this.canvas, this.cursor]);
      byId('charts').append(element('div', { className: 'chart' }, [this.head, this.plot]));
      this.height = height;
      this.drawInto = draw;
      const seek = (event) => {
        const box = this.plot.getBoundingClientRect(), left = gutter();
        setFrame(Math.round((event.clientX - box.left - left) / (box.width - left) * (frameCount - 1)));
      };
      // A finger may only want to scroll the page: it seeks by a tap or sideways.
      let from = null;
      this.plot.addEventListener('pointerdown', (event) => {
        this.plot.setPointerCapture(event.pointerId);
        from = event.clientX;
        pause();
        if (event.pointerType !== 'touch') seek(event);
      });
      this.plot.addEventListener('pointermove', (event) => {
        if (from === null) return;
        if (event.pointerType !== 'touch' || Math.abs(event.clientX - from) > 8) seek(event);
      });
      this.plot.addEventListener('pointerup', (event) => { if (from !== null) seek(event); from = null; });
      this.plot.addEventListener('pointercancel', () => { from = null; });
      charts.push(this);
    }
    draw() {
      const ratio = Math.min(2, window.devicePixelRatio || 1);
      this.width = this.plot.clientWidth || 300;
      this.canvas.width = Math.round(this.width * ratio);
      this.canvas.height = Math.round((this.height + AXIS) * ratio);
      this.canvas.style.height = (this.height + AXIS) + 'px';
      const pen = this.canvas.getContext('2d');
      pen.setTransform(ratio, 0, 0, ratio, 0, 0);
      pen.translate(gutter(), 0);
      this.drawInto(pen, this.width - gutter(), this.height);
      drawTimeAxis(pen, this.width - gutter(), this.height);
    }
    moveCursor(f) {
      this.cursor.style.transform = 'translateX(' + (gutter() + f / Math.max(1, frameCount - 1) * (this.width - gutter() - 1)).toFixed(1) + 'px)';
    }
  }

  function lineChart(title, unit, height, seriesOf) {
    const chart = new Chart(title, height, (pen, width) => {
      const series = seriesOf();
      let top = 0;
      const all = [];
      series.forEach((one) => { for (const v of one.values) if (v === v) all.push(v); });
      all.sort((a, b) => a - b);
      // A few wild values must not flatten the rest: they are cut at the edge.
      if (all.length) top = Math.min(all[all.length - 1], 2.5 * all[Math.floor(0.98 * (all.length - 1))]) * 1.05;
      // Angles have a sign: all of them are shown.
      if (chart.fromZero === null && all.length) top = all[all.length - 1] + 2;
      const low = chart.fromZero === null && all.length ? all[0] - 2 : chart.fromZero === false && all.length ? Math.max(0, all[Math.floor(0.02 * (all.length - 1))] * 0.85) : 0;
      const y = (v) => height - 2 - Math.min(1, Math.max(0, (v - low) / (top - low || 1))) * (height - 6);
      series.forEach((one) => drawSeries(pen, one, width, y));
      pen.fillStyle = dark() ? '#9aa6b5' : '#5b6675';
      pen.font = '11px system-ui, sans-serif';
      if (!all.length) { pen.fillText('nothing to show', 2, 11); return; }
      pen.textAlign = 'right';
      pen.fillText(human(top) + ' ' + unit, -6, 11);
      pen.fillText(human(low) + ' ' + unit, -6, height - 3);
      pen.textAlign = 'left';
      pen.fillRect(-2, 2, 1, height - 4);
    });
    return chart;
  }

  // One value a pixel column: the largest of those that fall into it.
  function drawSeries(pen, one, width, y) {
    if (one.low && !one.thin) drawBand(pen, one, width, y);
    pen.strokeStyle = one.colour();
    pen.lineWidth = one.thin ? 0.8 : 1.4;
    pen.globalAlpha = one.thin ? 0.7 : 1;
    pen.beginPath();
    let drawing = false;
    const columns = Math.min(frameCount, Math.floor(width));
    for (let c = 0; c < columns; ++c) {
      let value = NaN;
      const end = Math.floor((c + 1) * frameCount / columns);
      for (let f = Math.floor(c * frameCount / columns); f < end; ++f) {
        if (one.values[f] === one.values[f] && !(value > one.values[f])) value = one.values[f];
      }
      if (value !== value) { drawing = false; continue; }
      const x = c / Math.max(1, columns - 1) * (width - 1);
      if (drawing) pen.lineTo(x, y(value)); else { pen.moveTo(x, y(value)); pen.lineTo(x + 0.5, y(value)); }
      drawing = true;
    }
    pen.stroke();
    pen.globalAlpha = 1;
  }

  // From the lowest to the highest end of what falls into a pixel column.
  function drawBand(pen, one, width, y) {
    pen.fillStyle = one.colour();
    pen.globalAlpha = 0.22;
    const columns = Math.min(frameCount, Math.floor(width)), step = (width - 1) / Math.max(1, columns - 1);
    for (let c = 0; c < columns; ++c) {
      let low = Infinity, high = -Infinity;
      const end = Math.floor((c + 1) * frameCount / columns);
      for (let f = Math.floor(c * frameCount / columns); f < end; ++f) {
        if (one.low[f] < low) low = one.low[f];
        if (one.high[f] > high) high = one.high[f];
      }
      if (low <= high) pen.fillRect(c * step - step / 2, y(high), step, Math.max(1, y(low) - y(high)));
    }
    pen.globalAlpha = 1;
  }

  // Colours of the lead; the other results have the same, drawn thin.
  function legend(chart, all) {
    const series = all.filter((one) => !one.thin);
    series.slice(0, 12).forEach((one) => {
      const line = element('i');
      line.style.background = one.colour();
      chart.head.append(element('span', { className: 'key' }, [line, one.name]));
    });
    if (series.length > 12) chart.head.append(element('span', { className: 'key', textContent: 'and ' + (series.length - 12) + ' more' }));
    const others = new Set(all.filter((one) => one.thin).map((one) => one.source));
    if (others.size) thinKey(chart, 'thin: ', others);
  }

  function thinKey(chart, prefix, names) {
    chart.head.append(element('span', { className: 'key', textContent: prefix + Array.from(names).join(', ') }));
  }

  // A row's person, and whose result it is where there are several.
  function rowName(row, letters) {
    const name = nameOf(row.result, row.person) + (results.length > 1 ? ' ' + row.result.label : '');
    return name.length > letters ? name.slice(0, letters - 1) + '\u2026' : name;
  }

  function presenceChart() {
    const rows = [];
    results.forEach((result) => result.ids.forEach((id, person) => rows.push({ result: result, person: person })));
    const most = 40, shown = rows.slice(0, most), rowHeight = shown.length > 16 ? 8 : 15;
    const mostViews = Math.max(1, ...results.map((result) => {
      let m = 1;
      for (const s of result.status) m = Math.max(m, s >> 2);
      return m;
    }));
    const chart = new Chart('Who is tracked, by how many views', Math.max(1, shown.length) * rowHeight + 2, (pen, width) => {
      shown.forEach((row, i) => {
        pen.fillStyle = colourOf(row.result, row.person);
        const scale = width / frameCount;
        row.result.ofPerson[row.person].forEach((p) => {
          pen.globalAlpha = row.result.truth ? 0.5 : 0.2 + 0.8 * Math.min(1, meanViews(row.result, p) / mostViews);
          const h = row.result.index === 0 ? rowHeight - 3 : rowHeight * 0.45;
          const x = Math.floor(row.result.frame[p] * scale), end = Math.floor((row.result.frame[p] + 1) * scale);
          pen.fillRect(x, i * rowHeight + (rowHeight - h) / 2, Math.max(1, end - x), h);
        });
        pen.globalAlpha = 1;
        if (rowHeight < 12) return;
        pen.font = '11px system-ui, sans-serif';
        pen.textAlign = 'right';
        pen.fillStyle = dark() ? '#e7ebf0' : '#1b2430';
        pen.fillText(rowName(row, gutter() < 100 ? 9 : 18), -6, i * rowHeight + rowHeight - 4);
        pen.textAlign = 'left';
      });
      drawEdits(pen, width, shown, rowHeight);
    });
    chart.head.append(element('span', { className: 'key', textContent: 'full colour: ' + mostViews + ' views' + (results.some((result) => result.edits.length) ? '; diamonds: joined, cut, exchanged, undecided' : '') + (rows.length > most ? '; the first ' + most + ' of ' + rows.length : '') }));
    if (results.length > 1) thinKey(chart, 'thinner: ', results.slice(1).map((result) => result.label));
  }

  function makeCharts() {
    presenceChart();
    const lead = results[0];
    if (lead.residual) {
      const series = residualSeries(lead);
      legend(lineChart('Residual per camera', 'px', 90, () => series), series);
    }
    const compared = results.filter((result) => result.difference);
    if (compared.length) {
      const series = [].concat(...compared.map((result) => perPerson(result, (p) => result.difference[p] === NO_VALUE ? NaN : result.difference[p] * 0.1)));
      legend(lineChart('Distance to ' + referenceName(), 'cm', 80, () => series), series);
    }
    const speed = [].concat(...results.map((result) => perPerson(result, speedOf(result))));
    const speedChart = lineChart('Mean speed of joints', 'm/s', 80, () => speed);
    legend(speedChart, speed);
    angleChart();
    if (lead.bones.length === 0) return;
    let bones = [];
    const choose = (b) => {
      const names = lead.bones[b].map((j) => lead.joints[j]);
      bones = [].concat(...results.map((result) => {
        const own = names.map((name) => result.joints.indexOf(name));
        return own.includes(-1) ? [] : perPerson(result, boneLengthOf(result, own));
      }));
    };
    choose(0);
    const boneChart = lineChart('Bone length', 'cm', 80, () => bones);
    boneChart.fromZero = false;
    const select = element('select', { id: 'bone' });
    select.setAttribute('aria-label', 'Bone');
    lead.bones.forEach((bone, b) => select.append(element('option', { value: b, textContent: jointName(lead.joints[bone[0]]) + ' to ' + jointName(lead.joints[bone[1]]) })));
    select.addEventListener('change', () => { choose(Number(select.value)); boneChart.draw(); });
    boneChart.head.append(select);
  }

  // Degrees of one angle, with its interval where the page has covariances.
  function angleSeries(result, name) {
    const at = result.angles ? result.angles.names.indexOf(name) : -1;
    if (at < 0) return [];
    const listOf = (key) => {
      const texts = result.angles[key];
      return texts ? decode(texts[at], Int16Array) : null;
    };
    const degrees = (list) => (p) => list[p] === NO_ANGLE ? NaN : list[p] * result.angles.quantum;
    const series = perPerson(result, degrees(listOf('values')));
    const low = listOf('low'), high = listOf('high');
    if (low && high) {
      const lows = perPerson(result, degrees(low)), highs = perPerson(result, degrees(high));
      series.forEach((one, person) => { one.low = lows[person].values; one.high = highs[person].values; });
    }
    return series;
  }

  function angleName(name) {
    return jointName(name.replace(/^([lr]_[a-z]+)_/, '$1 '));
  }

  function angleChart() {
    const names = [];
    results.forEach((result) => (result.angles ? result.angles.names : []).forEach((name) => { if (!names.includes(name)) names.push(name); }));
    if (!names.length) return;
    let angles = [];
    const choose = (name) => { angles = [].concat(...results.map((result) => angleSeries(result, name))); };
    choose(names[0]);
    const chart = lineChart('Joint angle', '\u00b0', 90, () => angles);
    chart.fromZero = null;
    const select = element('select', { id: 'angle' });
    select.setAttribute('aria-label', 'Joint angle');
    names.forEach((name) => select.append(element('option', { value: name, textContent: angleName(name) })));
    select.addEventListener('change', () => { choose(select.value); chart.draw(); });
    chart.head.append(select);
    if (angles.some((one) => one.low)) chart.head.append(element('span', { className: 'key', textContent: 'bands: 95 % intervals' }));
  }

  // What distances are measured to.
  function referenceName() {
    return results.some((result) => result.truth) ? 'the truth' : results[1].label;
  }

  // ---- Summary ------------------------------------------------------------------

  function medianOf(values) {
    const sorted = Array.from(values).filter((v) => v === v).sort((a, b) => a - b);
    return sorted.length ? sorted[Math.floor(sorted.length / 2)] : NaN;
  }

  function summaryTable(summary) {
    const table = element('table', {}, [element('tr', {}, ['camera', 'matched', 'median', '90 %'].map((text) => element('th', { textContent: text })))]);
    summary.cameras.forEach((camera) => table.append(element('tr', {}, [camera.view, Math.round(100 * camera.matched_share) + ' %',
      human(camera.median_px) + ' px', human(camera.p90_px) + ' px'].map((text) => element('td', { textContent: text })))));
    return table;
  }

  // How the solver went, and what was learnt of the detector.
  function solverLines(summary) {
    const lines = [];
    const solver = summary.solver;
    if (solver && solver.solves > 0) {
      lines.push(solver.name + ': ' + solver.solves + ' solves, '
        + (solver.not_converged + solver.failed > 0 ? solver.not_converged + ' not converged, ' + solver.failed + ' failed' : 'all converged'));
    }
    return lines;
  }

  // What `track` learnt of the detector and the motion, behind a line to open.
  function learntPart(summary) {
    const noise = summary.noise;
    if (!noise || !noise.classes) return null;
    const row = (tag, cells) => element('tr', {}, cells.map((text) => element(tag, { textContent: text })));
    const rows = Object.keys(noise.classes).map((name) => {
      const one = noise.classes[name];
      return row('td', [name, human(one.sigma_px) + ' px', human(one.process_noise)]);
    });
    const part = element('details', {}, [element('summary', { textContent: 'Learnt from the take' })]);
    if (noise.error_time_s) part.append(element('p', { textContent: 'The detector\u2019s errors last ' + human(noise.error_time_s) + ' s.' }));
    part.append(element('table', {}, [row('th', ['joints', 'error', 'drive, m\u00b2/s\u00b3'])].concat(rows)));
    return part;
  }

  // Warnings of `track` and findings of `doctor`: what is wrong stands first.
  function makeFindings() {
    const list = byId('finding-list'), several = results.filter((result) => !result.truth).length > 1;
    // Options of a command stay in one piece where there is room.
    const words = (remedy) => remedy.split(/(--\S+)/).map((part) => (part.startsWith('--') ? element('code', { textContent: part }) : part));
    const add = (text, remedy) => list.append(element('li', {}, [text + '. ', element('span', { className: 'try' }, ['Try: '].concat(words(remedy)))]));
    const findings = data.doctor && data.doctor.findings || [];
    results.forEach((result, r) => {
      const summary = data.results[r].summary;
      // What the doctor says too is said once.
      const told = (warning) => findings.some((finding) => (finding.evidence || '').includes(warning.text));
      (summary && summary.warnings || []).filter((warning) => !told(warning)).forEach((warning) => add((several ? result.label + ': ' : '') + warning.text, warning.try));
    });
    findings.forEach((finding) => {
      const px = finding.after_px > 0 ? ', residual ' + human(finding.before_px) + ' to ' + human(finding.after_px) + ' px' : '';
      add('Doctor: ' + finding.kind.replace(/_/g, ' ') + (finding.camera ? ' of ' + finding.camera : '') + ', confidence '
        + Number(finding.confidence).toFixed(2) + px + (finding.evidence ? '; ' + finding.evidence : ''), finding.fix);
    });
    byId('findings').hidden = !list.firstChild;
  }

  // What `track` wrote of each result, and how far results are apart.
  function makeSummary() {
    const box = byId('summary');
    const line = (text, kind) => box.append(element('p', { textContent: text, className: kind || '' }));
    results.forEach((result, r) => {
      const summary = data.results[r].summary;
      if (results.length > 1 && summary) box.append(element('b', { textContent: result.label }));
      if (summary) {
        box.append(summaryTable(summary));
        const tall = summary.people.filter((person) => person.height_m).sort((a, b) => b.frames - a.frames).slice(0, 6);
        line(summary.people.length + ' identities, at most ' + summary.most_people_in_a_view + ' in a view'
          + (tall.length ? '; heights ' + tall.map((person) => person.height_m.toFixed(2) + ' m').join(', ') : ''));
        solverLines(summary).forEach((text) => line(text));
        if (summary.warnings.length) line(summary.warnings.length + (summary.warnings.length > 1 ? ' warnings' : ' warning') + ', at the top of the page', 'warning');
        const learnt = learntPart(summary);
        if (learnt) box.append(learnt);
      }
      if (result.difference && !result.truth) {
        const apart = medianOf(Array.from(result.difference, (d) => (d === NO_VALUE ? NaN : 0.1 * d)));
        if (apart === apart) line(result.label + ': ' + human(apart) + ' cm from ' + referenceName() + ' in the median');
      }
    });
    if (data.doctor) line('Doctor: ' + data.doctor.verdict + (data.doctor.findings.length ? ', see the top of the page' : ''), data.doctor.findings.length ? 'warning' : '');
    byId('summary-card').hidden = !box.firstChild;
  }

  // ---- Who is who ---------------------------------------------------------------

  // What was decided (NAME.identity.jsonl) and what is corrected here. Lines of
  // the take and of this page together are a file for `track --corrections`.
  const corrections = [];

  function callPerson(result, id) {
    const person = result.ids.indexOf(id);
    return person < 0 ? id : nameOf(result, person);
  }

  function tellEdit(result, edit) {
    const who = edit.persons.map((id) => callPerson(result, id));
    const margin = edit.margin === undefined ? '' : ' (margin ' + human(edit.margin) + ')';
    switch (edit.op) {
      case 'join': return who[1] + ' is ' + who[0] + margin;
      case 'undecided': return who[1] + ' may be ' + who[0] + margin;
      case 'swap': return who[0] + ' and ' + who[1] + ' exchanged' + margin;
      case 'cut': return who[0] + (edit.persons[1] === undefined ? ' is somebody else' : ' becomes ' + who[1]) + margin;
      case 'delete': return who[0] + ' is nobody';
      default: return edit.persons[0] + ' is called ' + edit.name;
    }
  }

  // The place on the page's clock of the frame where an edit begins to count.
  function placeOf(edit) {
    if (!edit.frames) return -1;
    const number = edit.op === 'join' || edit.op === 'undecided' ? edit.frames[1] : edit.frames[0];
    let f = 0;
    while (f < frameCount - 1 && frameNumbers[f + 1] <= number) ++f;
    return f;
  }

  // In the chart of presence: a mark at the row of everyone concerned.
  function drawEdits(pen, width, shown, rowHeight) {
    const row = (result, id) => shown.findIndex((one) => one.result === result && one.result.ids[one.person] === id);
    const draw = (result, edit, ids, mine) => {
      const f = placeOf(edit);
      if (f < 0) return;
      const x = Math.min(width - 3, (f + 0.5) * width / frameCount);
      new Set(ids.map((id) => row(result, id))).forEach((i) => {
        if (i < 0) return;
        const y = (i + 0.5) * rowHeight, size = Math.min(5, rowHeight / 2);
        pen.beginPath();
        [[0, -size], [size, 0], [0, size], [-size, 0]].forEach(([dx, dy]) => pen.lineTo(x + dx, y + dy));
        pen.closePath();
        pen.lineWidth = 1.5;
        pen.strokeStyle = mine ? '#d55e00' : dark() ? '#ffffff' : '#000000';
        pen.fillStyle = edit.op === 'undecided' ? 'transparent' : dark() ? '#1b2430' : '#ffffff';
        pen.fill();
        pen.stroke();
      });
    };
    results.forEach((result) => result.edits.forEach((edit) => draw(result, edit, edit.now, false)));
    corrections.forEach((edit) => draw(results[0], edit, edit.persons, true));
  }

  function lineOfCorrection(edit) {
    // Identities may be larger than a number of JavaScript: they stay texts.
    const parts = ['"op": ' + JSON.stringify(edit.op), '"persons": [' + edit.persons.join(', ') + ']'];
    if (edit.frames) parts.push('"frames": [' + edit.frames.join(', ') + ']');
    if (edit.name) parts.push('"name": ' + JSON.stringify(edit.name));
    return '{' + parts.join(', ') + '}';
  }

  function correctionsText() {
    return results[0].lines.concat(corrections.map(lineOfCorrection)).map((line) => line + '\n').join('');
  }

  function listEdits() {
    const list = byId('edits'), lead = results[0];
    list.textContent = '';
    const add = (edit, mine) => {
      const f = placeOf(edit);
      const button = element('button', { type: 'button' }, [element('span', { className: 'what', textContent: tellEdit(lead, edit) }),
        element('span', { className: 'when', textContent: edit.frames ? edit.frames.join('\u2013') : '' })]);
      button.title = edit.op;
      if (f >= 0) button.addEventListener('click', () => { pause(); setFrame(f); });
      const item = element('li', { className: mine ? 'mine' : '' }, [button]);
      if (mine) {
        const undo = element('button', { type: 'button', className: 'undo', textContent: '\u00d7', title: 'Take back' });
        undo.addEventListener('click', () => { corrections.splice(corrections.indexOf(edit), 1); changed(); });
        item.append(undo);
      }
      list.append(item);
    };
    lead.edits.forEach((edit) => add(edit, false));
    corrections.forEach((edit) => add(edit, true));
    if (!list.firstChild) list.append(element('li', { textContent: 'nothing was changed' }));
    byId('save-edits').disabled = corrections.length === 0;
  }

  function changed() {
    listEdits();
    charts.forEach((chart) => chart.draw());
  }

  // What the form says, or what is wrong with it.
  function readCorrection() {
    const op = byId('edit-op').value, one = byId('edit-one').value, other = byId('edit-other').value;
    const edit = { op: op, persons: [one] };
    if (op === 'join' || op === 'swap') {
      if (one === other) return 'two people are needed';
      edit.persons.push(other);
    }
    if (op === 'name') {
      edit.name = byId('edit-name').value.trim();
      return edit.name ? edit : 'a name is needed';
    }
    if (op === 'join') return edit;
    edit.frames = [Number(byId('edit-first').value), Number(byId('edit-last').value)];
    return edit.frames[0] <= edit.frames[1] ? edit : 'the last frame comes before the first';
  }

  function showFields() {
    const op = byId('edit-op').value;
    byId('edit-other').hidden = op !== 'join' && op !== 'swap';
    byId('edit-name').hidden = op !== 'name';
    byId('edit-range').hidden = op === 'name' || op === 'join';
  }

  function makeIdentity() {
    const lead = results[0];
    if (lead.truth || !lead.ids.length) return;
    byId('identity-card').hidden = false;
    ['edit-one', 'edit-other'].forEach((select) => lead.ids.forEach((id, person) => {
      byId(select).append(element('option', { value: id, textContent: nameOf(lead, person) }));
    }));
    byId('edit-first').value = frameNumbers[0];
    byId('edit-last').value = frameNumbers[frameCount - 1];
    byId('edit-from').addEventListener('click', () => { byId('edit-first').value = frameNumbers[state.frame]; });
    byId('edit-to').addEventListener('click', () => { byId('edit-last').value = frameNumbers[state.frame]; });
    byId('edit-op').addEventListener('change', showFields);
    byId('edit-add').addEventListener('click', () => {
      const edit = readCorrection();
      byId('edit-wrong').textContent = typeof edit === 'string' ? edit : '';
      if (typeof edit === 'string') return;
      corrections.push(edit);
      changed();
    });
    byId('save-edits').addEventListener('click', () => {
      const link = element('a', { download: 'corrections.jsonl', href: 'data:application/jsonl;charset=utf-8,' + encodeURIComponent(correctionsText()) });
      link.click();
    });
    byId('identity-toggle').addEventListener('click', () => {
      byId('identity-body').hidden = !byId('identity-body').hidden;
      byId('identity-toggle').setAttribute('aria-expanded', String(!byId('identity-body').hidden));
    });
    showFields();
    listEdits();
  }

  // ---- Worst moments ------------------------------------------------------------

  const KINDS = {
    residual: ['largest residual', (m) => ': ' + human(m.value) + ' px off the detection in ' + m.detail],
    speed: ['speed jump', (m) => ', ' + jointName(m.detail) + ': velocity jumps by ' + human(m.value) + ' m/s'],
    bone: ['bone length jump', (m) => ', ' + jointName(m.detail) + ': length jumps by ' + human(100 * m.value) + ' cm'],
    difference: [results.some((r) => r.truth) ? 'far from the truth' : 'results differ', (m) => ': ' + human(100 * m.value) + ' cm from ' + referenceName()],
    start: ['identity appears', () => ' appears'],
    end: ['identity is lost', () => ' is lost']
  };

  function makeMoments() {
    const select = byId('moment-kind');
    select.append(element('option', { value: '', textContent: 'all kinds' }));
    Object.keys(KINDS).filter((kind) => data.moments.some((m) => m.kind === kind))
      .forEach((kind) => select.append(element('option', { value: kind, textContent: KINDS[kind][0] })));
    select.addEventListener('change', listMoments);
    listMoments();
  }

  function listMoments() {
    const kind = byId('moment-kind').value, list = byId('moments');
    list.textContent = '';
    data.moments.filter((m) => !kind || m.kind === kind).forEach((moment) => {
      const result = results[moment.result], person = result.ids.indexOf(moment.id);
      const dot = element('span', { className: 'dot' });
      dot.style.background = colourOf(result, person);
      const what = 'person ' + nameOf(result, person) + KINDS[moment.kind][1](moment) + (result.index > 0 ? ' (' + result.label + ')' : '');
      const button = element('button', { type: 'button' }, [dot, element('span', { className: 'what', textContent: what }), element('span', { className: 'when', textContent: String(moment.frame) })]);
      button.title = KINDS[moment.kind][0];
      button.dataset.at = moment.at;
      button.addEventListener('click', () => { pause(); setFrame(moment.at); });
      list.append(element('li', {}, [button]));
    });
    if (!list.firstChild) list.append(element('li', { textContent: 'none' }));
  }

  // ---- Playback -----------------------------------------------------------------

  const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4];
  const state = { frame: 0, playing: false, speed: 1, time: times[0] || 0, lastTick: 0, pictures: 0 };
  let scene = null;

  function setFrame(f) {
    state.frame = Math.max(0, Math.min(frameCount - 1, f));
    state.time = times[state.frame];
    update();
  }

  function update() {
    const f = state.frame;
    if (scene) scene.setFrame(f);
    panels.forEach((panel) => { if (panel.seen) drawPanel(panel, f); });
    charts.forEach((chart) => chart.moveCursor(f));
    byId('scrub').value = f;
    byId('clock').textContent = 'frame ' + frameNumbers[f] + ' \u00b7 ' + times[f].toFixed(2) + ' s';
  }

  function play() {
    if (state.frame >= frameCount - 1) setFrame(0);
    state.playing = true;
    state.lastTick = 0;
    byId('play').textContent = 'Pause';
  }
  function pause() {
    state.playing = false;
    byId('play').textContent = 'Play';
    // Videos stop at the very picture.
    panels.forEach((panel) => { if (panel.video && panel.seen) drawPanel(panel, state.frame); });
  }

  function tick(now) {
    if (state.playing) {
      const elapsed = state.lastTick ? Math.min(0.25, (now - state.lastTick) / 1000) : 0;
      state.lastTick = now;
      const target = state.time + elapsed * state.speed;
      let f = state.frame;
      while (f < frameCount - 1 && times[f + 1] <= target) ++f;
      const moved = f !== state.frame;
      state.frame = f;
      state.time = target;
      if (moved) update();
      if (f >= frameCount - 1) pause();
    }
    if (scene) scene.render();
    ++state.pictures;
    window.requestAnimationFrame(tick);
  }

  function changeSpeed(step) {
    const at = Math.max(0, Math.min(SPEEDS.length - 1, SPEEDS.indexOf(state.speed) + step));
    state.speed = SPEEDS[at];
    byId('speed').value = String(state.speed);
  }

  function onKey(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const tag = event.target.tagName;
    if (tag === 'SELECT' || (tag === 'BUTTON' && (event.key === ' ' || event.key === 'Enter'))) return;
    const stride = event.shiftKey ? 10 : 1;
    const actions = {
      ' ': () => (state.playing ? pause() : play()),
      ArrowLeft: () => { pause(); setFrame(state.frame - stride); },
      ArrowRight: () => { pause(); setFrame(state.frame + stride); },
      Home: () => { pause(); setFrame(0); },
      End: () => { pause(); setFrame(frameCount - 1); },
      '+': () => changeSpeed(1), '=': () => changeSpeed(1), '-': () => changeSpeed(-1)
    };
    if (!Object.prototype.hasOwnProperty.call(actions, event.key)) return;
    event.preventDefault();
    actions[event.key]();
  }

  // ---- A picture to keep -----------------------------------------------------------

  // What drawing on a canvas needs here, written as SVG.
  class SvgPen {
    constructor() {
      Object.assign(this, { out: [], x: 0, y: 0, scale: 1, path: '', dash: [], fillStyle: '#000', strokeStyle: '#000', lineWidth: 1,
        globalAlpha: 1, font: '12px sans-serif', textAlign: 'left', lineCap: 'butt' });
    }
    place(x, y, scale) { Object.assign(this, { x: x, y: y, scale: scale }); }
    at(x, y) { return (this.x + this.scale * x).toFixed(1) + ' ' + (this.y + this.scale * y).toFixed(1); }
    long(length) { return (this.scale * length).toFixed(2); }
    colour(name, value) {
      return ' ' + name + '="' + value + '"' + (this.globalAlpha < 1 ? ' ' + name + '-opacity="' + this.globalAlpha.toFixed(2) + '"' : '');
    }
    outline(style) {
      return ' fill="none"' + this.colour('stroke', style) + ' stroke-width="' + this.long(this.lineWidth) + '" stroke-linecap="' + this.lineCap + '"'
        + (this.dash.length ? ' stroke-dasharray="' + this.dash.map((d) => this.long(d)).join(' ') + '"' : '');
    }
    beginPath() { this.path = ''; }
    moveTo(x, y) { this.path += 'M' + this.at(x, y); }
    lineTo(x, y) { this.path += 'L' + this.at(x, y); }
    arc(x, y, r) {
      const turn = 'A' + this.long(r) + ' ' + this.long(r) + ' 0 1 1 ';
      this.path += 'M' + this.at(x - r, y) + turn + this.at(x + r, y) + turn + this.at(x - r, y);
    }
    stroke() { if (this.path) this.out.push('<path d="' + this.path + '"' + this.outline(this.strokeStyle) + '/>'); }
    fill() { if (this.path) this.out.push('<path d="' + this.path + '"' + this.colour('fill', this.fillStyle) + '/>'); }
    box(x, y, width, height) {
      const [left, top] = this.at(x, y).split(' ');
      return '<rect x="' + left + '" y="' + top + '" width="' + this.long(width) + '" height="' + this.long(height) + '"';
    }
    fillRect(x, y, width, height) { this.out.push(this.box(x, y, width, height) + this.colour('fill', this.fillStyle) + '/>'); }
    strokeRect(x, y, width, height) { this.out.push(this.box(x, y, width, height) + this.outline(this.strokeStyle) + '/>'); }
    setLineDash(dash) { this.dash = dash; }
    text(text, x, y, how) {
      const [left, top] = this.at(x, y).split(' '), size = /([\d.]+)px/.exec(this.font)[1];
      const anchor = { left: 'start', center: 'middle', right: 'end' }[this.textAlign];
      this.out.push('<text x="' + left + '" y="' + top + '" font-family="sans-serif" font-size="' + this.long(size) + '"'
        + (/^600/.test(this.font) ? ' font-weight="600"' : '') + ' text-anchor="' + anchor + '"' + how + '>' + escaped(text) + '</text>');
    }
    fillText(text, x, y) { this.text(text, x, y, this.colour('fill', this.fillStyle)); }
    strokeText(text, x, y) { this.text(text, x, y, this.outline(this.strokeStyle)); }
    drawImage(image, x, y, width, height) {
      if (image.tagName === 'VIDEO') return this.drawVideo(image, x, y, width, height);
      this.out.push(this.box(x, y, width, height).replace('<rect', '<image') + ' preserveAspectRatio="none" href="' + escaped(image.src) + '"/>');
    }
  }

  // Its picture as a file of its own; one that is linked from a disk may not be
  // read and is left out.
  SvgPen.prototype.drawVideo = function (video, x, y, width, height) {
    const canvas = element('canvas', { width: video.videoWidth, height: video.videoHeight });
    canvas.getContext('2d').drawImage(video, 0, 0);
    try {
      this.drawImage({ src: canvas.toDataURL('image/jpeg') }, x, y, width, height);
    } catch (error) {
      // A browser's rule, no fault: the lines are there.
    }
  };

  function escaped(text) {
    return String(text).replace(/[&<>"]/g, (c) => ({ '&': '&amp;', '<': '&lt;', '>': '&gt;', '"': '&quot;' }[c]));
  }

  // Where things stand in the picture: the 3D view, and the panels in rows below.
  function pictureLayout() {
    const width = 1600, gap = 12, head = 30;
    const stage = { x: 0, y: head, width: width, height: scene ? Math.round(width * scene.height / scene.width) : 0 };
    const count = panels.length, inRow = Math.max(1, Math.ceil(count / Math.max(1, Math.ceil(count / 4))));
    let y = stage.y + stage.height + gap;
    const cells = [];
    for (let first = 0; first < count; first += inRow) {
      const row = panels.slice(first, first + inRow), across = (width - gap * (row.length - 1)) / row.length;
      let tallest = 0;
      row.forEach((panel, i) => {
        const height = across * panel.height / panel.width;
        tallest = Math.max(tallest, height);
        cells.push({ panel: panel, x: i * (across + gap), y: y, width: across, height: height });
      });
      y += tallest + 22 + gap;
    }
    return { width: width, height: Math.ceil(y), stage: stage, cells: cells };
  }

  function pictureTitle() {
    return data.title + ', frame ' + frameNumbers[state.frame] + ', ' + times[state.frame].toFixed(2) + ' s';
  }

  function pageColours() {
    return dark() ? { page: '#12161c', stage: '#0d1116', ink: '#e7ebf0', quiet: '#9aa6b5', grid: '#3a4450' }
      : { page: '#ffffff', stage: '#e9edf2', ink: '#1b2430', quiet: '#5b6675', grid: '#c3cbd4' };
  }

  // The 3D view as lines, far ones first. `unit` is one pixel of the screen.
  function paintScene(pen, stage, colours) {
    const view = scene.camera, scale = stage.height / 2 / Math.tan(view.fov * Math.PI / 360);
    const toScreen = (point) => {
      const depth = -scratch.direction.copy(point).applyMatrix4(view.matrixWorldInverse).z;
      scratch.direction.copy(point).project(view);
      return { x: stage.x + (scratch.direction.x + 1) / 2 * stage.width, y: stage.y + (1 - scratch.direction.y) / 2 * stage.height, depth: depth };
    };
    const strokes = [];
    const add = (a, b, metres, colour, alpha) => {
      const from = toScreen(a), to = toScreen(b);
      if (from.depth < 0.1 || to.depth < 0.1) return;
      strokes.push({ from: from, to: to, depth: (from.depth + to.depth) / 2, width: Math.max(0.6, metres * scale * 2 / (from.depth + to.depth)), colour: colour, alpha: alpha });
    };
    if (show.floor) floorLines().forEach(([a, b]) => add(a, b, 0.004, colours.grid, 1));
    if (show.cameras) scene.cameraLines.forEach(([a, b]) => add(a, b, 0.006, colours.quiet, 0.9));
    results.forEach((result) => {
      if (!result.visible) return;
      const J = result.joints.length, a = new THREE.Vector3(), b = new THREE.Vector3();
      for (let p = result.start[state.frame]; p < result.start[state.frame + 1]; ++p) {
        const status = (j) => result.status[p * J + j] & 3, colour = colourOf(result, result.person[p]);
        const thick = result.index === 0 ? 0.045 : 0.02;
        result.bones.forEach(([j, k]) => {
          const least = Math.min(status(j), status(k));
          if (least === MISSING) return;
          add(a.fromArray(result.xyz, (p * J + j) * 3), b.fromArray(result.xyz, (p * J + k) * 3), thick, colour, least === INFERRED ? 0.35 : 1);
        });
      }
    });
    strokes.sort((one, other) => other.depth - one.depth);
    pen.lineCap = 'round';
    pen.setLineDash([]);
    strokes.forEach((stroke) => {
      pen.globalAlpha = stroke.alpha;
      pen.strokeStyle = stroke.colour;
      pen.lineWidth = stroke.width;
      pen.beginPath();
      pen.moveTo(stroke.from.x, stroke.from.y);
      pen.lineTo(stroke.to.x, stroke.to.y);
      pen.stroke();
    });
    pen.globalAlpha = 1;
    if (show.labels) paintNames(pen, toScreen, colours);
  }

  function paintNames(pen, toScreen, colours) {
    const lead = results.find((result) => result.visible);
    if (!lead) return;
    pen.font = '600 16px system-ui, sans-serif';
    pen.textAlign = 'center';
    for (let p = lead.start[state.frame]; p < lead.start[state.frame + 1]; ++p) {
      const at = toScreen(headOf(lead, p));
      if (at.depth < 0.1) continue;
      pen.lineWidth = 4;
      pen.strokeStyle = colours.stage;
      pen.strokeText(nameOf(lead, lead.person[p]), at.x, at.y);
      pen.fillStyle = colours.ink;
      pen.fillText(nameOf(lead, lead.person[p]), at.x, at.y);
    }
    pen.textAlign = 'left';
  }

  function floorLines() {
    const size = Math.ceil(reach * 1.6), lines = [];
    const point = (x, z) => new THREE.Vector3(x, 0, z).applyQuaternion(scene.floor.quaternion).add(scene.floor.position);
    for (let i = -size; i <= size; ++i) lines.push([point(i, -size), point(i, size)], [point(-size, i), point(size, i)]);
    return lines;
  }

  function paintTexts(pen, layout, colours) {
    pen.globalAlpha = 1;
    pen.textAlign = 'left';
    pen.fillStyle = colours.ink;
    pen.font = '600 16px system-ui, sans-serif';
    pen.fillText(pictureTitle(), 8, 21);
    pen.font = '13px system-ui, sans-serif';
    layout.cells.forEach((cell) => pen.fillText(cell.panel.camera.view, cell.x + 4, cell.y + cell.height + 16));
  }

  function svgPicture() {
    const layout = pictureLayout(), colours = pageColours(), pen = new SvgPen();
    pen.fillStyle = colours.page;
    pen.fillRect(0, 0, layout.width, layout.height);
    const clips = [];
    const framed = (box, paint) => {
      clips.push('<clipPath id="clip' + clips.length + '"><rect x="' + box.x + '" y="' + box.y + '" width="' + box.width + '" height="' + box.height + '"/></clipPath>');
      pen.out.push('<g clip-path="url(#clip' + (clips.length - 1) + ')">');
      pen.fillStyle = colours.stage;
      pen.fillRect(box.x, box.y, box.width, box.height);
      paint();
      pen.place(0, 0, 1);
      pen.out.push('</g>');
    };
    if (scene) framed(layout.stage, () => paintScene(pen, layout.stage, colours));
    layout.cells.forEach((cell) => framed(cell, () => {
      const scale = cell.width / cell.panel.width;
      pen.place(cell.x, cell.y, scale);
      paintPanel(pen, cell.panel, state.frame, 1.2 / scale, true);
    }));
    paintTexts(pen, layout, colours);
    return '<svg xmlns="http://www.w3.org/2000/svg" width="' + layout.width + '" height="' + layout.height + '" viewBox="0 0 ' + layout.width + ' ' + layout.height + '">\n<defs>'
      + clips.join('') + '</defs>\n' + pen.out.join('\n') + '\n</svg>\n';
  }

  // A canvas; pictures that are linked from a disk would forbid saving it and are
  // left out (`withPictures` false).
  function pngCanvas(withPictures) {
    const layout = pictureLayout(), colours = pageColours();
    const canvas = element('canvas', { width: layout.width, height: layout.height }), pen = canvas.getContext('2d');
    pen.fillStyle = colours.page;
    pen.fillRect(0, 0, layout.width, layout.height);
    if (scene) {
      const box = layout.stage;
      pen.fillStyle = colours.stage;
      pen.fillRect(box.x, box.y, box.width, box.height);
      scene.dirty = true;
      scene.render();  // what it drew is there until the browser shows it
      pen.drawImage(scene.canvas, box.x, box.y, box.width, box.height);
      if (show.labels) {
        scratch.matrix.copy(scene.camera.matrixWorldInverse);
        paintNames(pen, (point) => {
          const depth = -scratch.direction.copy(point).applyMatrix4(scratch.matrix).z;
          scratch.direction.copy(point).project(scene.camera);
          return { x: box.x + (scratch.direction.x + 1) / 2 * box.width, y: box.y + (1 - scratch.direction.y) / 2 * box.height, depth: depth };
        }, colours);
      }
    }
    layout.cells.forEach((cell) => {
      const scale = cell.width / cell.panel.width;
      pen.save();
      pen.beginPath();
      pen.rect(cell.x, cell.y, cell.width, cell.height);
      pen.clip();
      pen.fillStyle = colours.stage;
      pen.fillRect(cell.x, cell.y, cell.width, cell.height);
      pen.setTransform(scale, 0, 0, scale, cell.x, cell.y);
      paintPanel(pen, cell.panel, state.frame, 1.2 / scale, withPictures);
      pen.restore();
    });
    paintTexts(pen, layout, colours);
    return canvas;
  }

  function pngUrl() {
    try {
      return pngCanvas(true).toDataURL('image/png');
    } catch (error) {
      return pngCanvas(false).toDataURL('image/png');
    }
  }

  function save(url, extension) {
    const name = data.title.replace(/[^\w.-]+/g, '_') + '_' + frameNumbers[state.frame] + '.' + extension;
    const link = element('a', { href: url, download: name });
    document.body.append(link);
    link.click();
    link.remove();
  }

  function savePng() { save(pngUrl(), 'png'); }

  function saveSvg() {
    const url = URL.createObjectURL(new Blob([svgPicture()], { type: 'image/svg+xml' }));
    save(url, 'svg');
    window.setTimeout(() => URL.revokeObjectURL(url), 10000);
  }

  // ---- Page ---------------------------------------------------------------------

  function applyTheme(isDark) {
    document.documentElement.classList.toggle('dark', isDark);
    byId('theme').textContent = isDark ? 'Light' : 'Dark';
    if (scene) scene.recolour();
    if (panels.length) panels.forEach((panel) => drawPanel(panel, state.frame));
    charts.forEach((chart) => chart.draw());
    if (charts.length) listMoments();
  }

  function resize() {
    if (scene) scene.resize();
    sizePanels();
    charts.forEach((chart) => chart.draw());
    update();
  }

  function makeHeader() {
    byId('title').textContent = data.title;
    const seconds = times[frameCount - 1] - times[0];
    byId('subtitle').textContent = frameCount + ' frames, ' + seconds.toFixed(1) + ' s, ' + results[0].ids.length + ' identities'
      + (data.cameras.length ? ', ' + data.cameras.length + ' cameras' : '');
    const notes = [];
    if (data.assumedRate) notes.push('The files tell no times: ' + data.assumedRate + ' frames a second are assumed.');
    if (data.frameStride > 1) notes.push('To save space this page holds one frame in ' + data.frameStride + '.');
    if (data.extrasStride > 1) notes.push('Detections and covariances are those of one frame in ' + data.extrasStride + '.');
    byId('notes').textContent = notes.join(' ');
    byId('notes').hidden = notes.length === 0;
    const megabytes = (bytes) => (bytes / 1e6).toFixed(1) + ' MB';
    const sizes = [];
    if (data.bytes.detections) sizes.push('detections ' + megabytes(data.bytes.detections));
    if (data.bytes.pictures) sizes.push('pictures ' + megabytes(data.bytes.pictures));
    if (data.bytes.covariances) sizes.push('covariances ' + megabytes(data.bytes.covariances));
    if (sizes.length) byId('sizes').textContent = 'Of this page: ' + sizes.join(', ') + '.';
    results.forEach((result) => {
      const box = element('input', { type: 'checkbox', checked: true });
      box.addEventListener('change', () => { result.visible = box.checked; update(); });
      const style = results.length < 2 ? '' : result.truth ? ' (ground truth: thin, grey)' : result.index ? ' (thin)' : ' (thick)';
      byId('results').append(element('label', {}, [box, ' ' + result.label, element('span', { className: 'style', textContent: style })]));
    });
  }

  function connect() {
    byId('scrub').max = frameCount - 1;
    byId('scrub').addEventListener('input', () => { pause(); setFrame(Number(byId('scrub').value)); });
    byId('play').addEventListener('click', () => (state.playing ? pause() : play()));
    byId('step-back').addEventListener('click', () => { pause(); setFrame(state.frame - 1); });
    byId('step-on').addEventListener('click', () => { pause(); setFrame(state.frame + 1); });
    SPEEDS.forEach((speed) => byId('speed').append(element('option', { value: String(speed), textContent: speed + '\u00d7' })));
    byId('speed').value = '1';
    byId('speed').addEventListener('change', () => { state.speed = Number(byId('speed').value); });
    ['trails', 'labels', 'cameras', 'floor', 'ellipsoids'].forEach((name) => {
      byId('show-' + name).addEventListener('change', (event) => { show[name] = event.target.checked; update(); });
    });
    byId('ellipsoid-option').hidden = !results.some((result) => result.covariance);
    byId('reset-view').addEventListener('click', () => scene && scene.home());
    byId('save-png').addEventListener('click', savePng);
    byId('save-svg').addEventListener('click', saveSvg);
    byId('theme').addEventListener('click', () => applyTheme(!dark()));
    byId('help-button').addEventListener('click', () => {
      byId('help').hidden = !byId('help').hidden;
      byId('help-button').setAttribute('aria-expanded', String(!byId('help').hidden));
    });
    document.addEventListener('keydown', onKey);
    window.addEventListener('resize', resize);
  }

  document.documentElement.classList.toggle('dark', window.matchMedia('(prefers-color-scheme: dark)').matches);
  makeHeader();
  try {
    scene = new Scene(byId('scene'));
  } catch (error) {
    byId('no-webgl').hidden = false;
  }
  makePanels();
  makeCharts();
  makeMoments();
  makeFindings();
  makeSummary();
  makeIdentity();
  connect();
  applyTheme(dark());
  resize();
  window.requestAnimationFrame(tick);
  // For tests and for curious people at the console.
  window.kinegraph = { state: state, setFrame: setFrame, play: play, pause: pause, results: results, scene: scene, panels: panels, palette: PALETTE,
    svgPicture: svgPicture, pngUrl: pngUrl, corrections: corrections, correctionsText: correctionsText };
})();
