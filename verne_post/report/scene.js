// The machine as solids, and the tool path on its table: one scene, drawn when something has changed. Lengths in mm, z up.
const Scene = (() => {
  const COLOURS = {
    guide: 0xb7c0c9, slider: 0x5580ab, rod: 0xe3e7eb, ball: 0x76818c, platform: 0x6f93b5, spindle: 0xa9b1b9, nose: 0x6a747e,
    cutter: 0xe0b23c, holder: 0x7b848d, table: 0xb7c2cc, groove: 0x97a5b1, cradle: 0x7c90a4, base: 0xc3cbd2, stock: 0xd9a066,
    fixture: 0x3f9c8f, bad: 0xd32f2f,
  };
  const AXES = [["X", 0xc0392b], ["Y", 0x2e8b45], ["Z", 0x2f6fc4]];
  const vector = array => new THREE.Vector3(array[0], array[1], array[2]);
  const material = (name, more) => new THREE.MeshLambertMaterial({ color: COLOURS[name], ...more });
  const solid = (geometry, what) => new THREE.Mesh(geometry, what);
  const box = (x, y, z, what) => solid(new THREE.BoxGeometry(x, y, z), what);

  // a cylinder along z from one height to another
  function pillar(radius, low, high, what, top = radius, sides = 32) {
    const mesh = solid(new THREE.CylinderGeometry(top, radius, high - low, sides), what);
    mesh.geometry.rotateX(Math.PI / 2);
    mesh.position.z = (low + high) / 2;
    return mesh;
  }

  // the convex outline of points [x, y], counterclockwise
  function outline(points) {
    const sorted = points.map(p => [p[0], p[1]]).sort((a, b) => a[0] - b[0] || a[1] - b[1]);
    const half = list => list.reduce((kept, p) => {
      while (kept.length > 1) {
        const [a, b] = kept.slice(-2);
        if ((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0) break;
        kept.pop();
      }
      kept.push(p);
      return kept;
    }, []);
    return [...half(sorted).slice(0, -1), ...half(sorted.reverse()).slice(0, -1)];
  }

  function makeTable(scene, model) {
    const r = model.radius, group = new THREE.Group(), tilting = new THREE.Group(), turning = new THREE.Group();
    const face = material("table"), cradle = material("cradle"), base = material("base");
    turning.add(pillar(r, -32, 0, face, r, 64), pillar(0.45 * r, -80, -32, cradle));
    for (let k = 0; k < 4; k++) {
      const groove = box(1.9 * r, 10, 2, material("groove"));
      groove.rotation.z = k * Math.PI / 4;
      groove.position.z = -0.6;
      turning.add(groove);
    }
    const marker = box(0.3 * r, 16, 2, material("nose"));
    marker.position.set(0.8 * r, 0, -0.4);
    turning.add(marker);
    turning.position.copy(vector(model.offset));
    const yoke = box(2 * r + 90, 0.7 * r, 40, cradle);
    yoke.position.z = -105;
    tilting.add(yoke, turning);
    for (const side of [-1, 1]) {
      const arm = box(24, 0.5 * r, 150, cradle), pin = pillar(32, -30, 30, material("nose")), post = box(44, 0.6 * r, r + 190, base);
      arm.position.set(side * (r + 34), 0, -55);
      pin.rotation.y = Math.PI / 2;
      pin.position.set(side * (r + 60), 0, 0);
      post.position.set(side * (r + 84), 0, 40 - (r + 190) / 2);
      tilting.add(arm, pin);
      group.add(post);
    }
    const floor = box(2 * r + 320, 2 * r + 160, 24, base);
    floor.position.z = -(r + 162);
    group.add(floor, tilting);
    group.position.copy(vector(model.pivot));
    scene.add(group);
    return { tilting, turning, face };
  }

  // one rail and slider for every joint that carries rods
  function makeGuides(scene, model) {
    const joints = new Map(), middle = new THREE.Vector3();
    model.guides.forEach((guide, rod) => {
      if (!guide.ends) return;
      if (!joints.has(guide.joint)) joints.set(guide.joint, []);
      joints.get(guide.joint).push(rod);
      middle.add(vector(guide.ends[0])).add(vector(guide.ends[1]));
    });
    middle.multiplyScalar(0.5 / Math.max(model.guides.length, 1));
    const made = [];
    for (const [joint, rods] of joints) {
      const ends = [0, 1].map(k => rods.reduce((sum, rod) => sum.add(vector(model.guides[rod].ends[k])), new THREE.Vector3()).multiplyScalar(1 / rods.length));
      const along = ends[1].clone().sub(ends[0]), travel = along.length();
      along.normalize();
      const out = ends[0].clone().add(ends[1]).multiplyScalar(0.5).sub(middle);
      // seen from the middle the rods of a slider lie side by side
      const first = vector(model.guides[rods[0]].ends[0]), aside = new THREE.Vector3();
      for (const rod of rods) aside.add(vector(model.guides[rod].ends[0])).sub(first);
      const spread = 2 * aside.length() / rods.length;
      if (spread > 1) out.addScaledVector(aside.normalize(), -out.dot(aside));
      out.addScaledVector(along, -out.dot(along));
      if (out.length() < 1) out.set(along.z, along.x, along.y).addScaledVector(along, -(along.z * along.x + along.x * along.y + along.y * along.z));
      aside.crossVectors(along, out.normalize());
      const turn = new THREE.Quaternion().setFromRotationMatrix(new THREE.Matrix4().makeBasis(out, aside, along));
      const what = material("slider"), slider = new THREE.Group(), block = box(46, spread + 84, 120, what);
      block.position.x = 42;
      slider.add(block);
      slider.quaternion.copy(turn);
      const rail = new THREE.Group(), beam = box(46, spread + 60, travel + 170, material("guide"));
      beam.position.x = 90;
      rail.add(beam);
      for (const end of [-1, 1]) {
        const stop = box(30, 30, 8, material("nose"));
        stop.position.set(beam.position.x - 26, 0, end * (travel / 2 + 72));
        rail.add(stop);
      }
      rail.quaternion.copy(turn);
      rail.position.copy(ends[0]).add(ends[1]).multiplyScalar(0.5);
      scene.add(slider, rail);
      made.push({ joint, rods, slider, what });
    }
    return made;
  }

  function makePlatform(scene, model) {
    const group = new THREE.Group();
    const body = material("platform");
    if (model.joints.length > 2) {
      const heights = model.joints.map(p => p[2]), height = heights.reduce((a, b) => a + b, 0) / heights.length;
      const shape = new THREE.Shape(outline(model.joints).map(p => new THREE.Vector2(p[0], p[1])));
      const plate = solid(new THREE.ExtrudeGeometry(shape, { depth: 34, bevelEnabled: true, bevelSize: 18, bevelThickness: 4, bevelSegments: 2 }), body);
      plate.position.z = height - 17;
      group.add(plate);
    }
    const r = model.spindleRadius;
    group.add(pillar(r, 30, model.spindleTop, material("spindle")), pillar(0.6 * r, 0, 30, material("nose"), r));
    scene.add(group);
    return group;
  }

  function makeRods(scene, model, count) {
    const rods = [], ball = new THREE.SphereGeometry(1.9 * model.rodRadius, 20, 14);
    for (let k = 0; k < count; k++) {
      const geometry = new THREE.CylinderGeometry(model.rodRadius, model.rodRadius, 1, 18);
      geometry.rotateX(Math.PI / 2);
      const bar = solid(geometry, material("rod")), ends = [solid(ball, material("ball")), solid(ball, material("ball"))];
      scene.add(bar, ...ends);
      rods.push({ bar, ends });
    }
    return rods;
  }

  // a cylinder along z about its middle, with a bore
  function tube(radius, bore, height, what) {
    const shape = new THREE.Shape().absarc(0, 0, radius, 0, 2 * Math.PI);
    if (bore > 0) shape.holes.push(new THREE.Path().absarc(0, 0, bore, 0, 2 * Math.PI, true));
    const geometry = new THREE.ExtrudeGeometry(shape, { depth: height, bevelEnabled: false, curveSegments: 48 });
    geometry.translate(0, 0, -height / 2);
    return solid(geometry, what);
  }

  function makeBoxes(turning, model) {
    for (const one of model.boxes) {
      const what = one.stock ? material("stock", { transparent: true, opacity: 0.4, depthWrite: false }) : material("fixture", { transparent: true, opacity: 0.85 });
      const mesh = one.round ? tube(one.half[0], one.bore, 2 * one.half[2], what) : box(...one.half.map(half => 2 * half), what);
      mesh.position.copy(vector(one.middle));
      mesh.rotation.z = one.turn;
      const edges = new THREE.LineSegments(new THREE.EdgesGeometry(mesh.geometry), new THREE.LineBasicMaterial({ color: one.stock ? 0x9a6527 : 0x1f5f56 }));
      mesh.add(edges);
      turning.add(mesh);
    }
  }

  function label(text, colour) {
    const canvas = document.createElement("canvas");
    canvas.width = canvas.height = 64;
    const context = canvas.getContext("2d");
    context.font = "bold 44px system-ui, sans-serif";
    context.textAlign = "center";
    context.textBaseline = "middle";
    context.fillStyle = "#" + colour.toString(16).padStart(6, "0");
    context.fillText(text, 32, 34);
    return new THREE.Sprite(new THREE.SpriteMaterial({ map: new THREE.CanvasTexture(canvas), depthTest: false }));
  }

  // the triad of the machine's axes, z up
  function makeTriad() {
    const scene = new THREE.Scene();
    AXES.forEach(([name, colour], k) => {
      const direction = new THREE.Vector3().setComponent(k, 1);
      scene.add(new THREE.ArrowHelper(direction, new THREE.Vector3(), 1, colour, 0.32, 0.18));
      const sprite = label(name, colour);
      sprite.position.copy(direction).multiplyScalar(1.32);
      sprite.scale.setScalar(0.6);
      scene.add(sprite);
    });
    return { scene, camera: new THREE.OrthographicCamera(-1.7, 1.7, 1.7, -1.7, 0.1, 10) };
  }

  function make(canvas, close, data, arrays) {
    const model = data.scene, rodCount = data.shapes.rods[1];
    const renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true, preserveDrawingBuffer: true });
    renderer.autoClear = false;
    const scene = new THREE.Scene(), solids = new THREE.Group(), marks = new THREE.Group();
    const camera = new THREE.PerspectiveCamera(28, 1, 1, 20000);
    camera.up.set(0, 0, 1);
    const controls = new THREE.OrbitControls(camera, canvas);
    // the close-up goes with the tip; its picture is drawn by the same renderer and copied
    const follower = camera.clone(), following = new THREE.OrbitControls(follower, close), paper = close.getContext("2d");
    following.enablePan = false;
    scene.add(new THREE.HemisphereLight(0xffffff, 0xa9b1b9, 0.8));
    for (const [place, strength] of [[[1.5, -2, 2.5], 0.45], [[-2, -1, 0.8], 0.2]]) {
      const light = new THREE.DirectionalLight(0xffffff, strength);
      light.position.set(...place);
      scene.add(light);
    }
    scene.add(solids);
    const table = makeTable(solids, model), guides = makeGuides(solids, model), platform = makePlatform(solids, model);
    const rods = makeRods(solids, model, rodCount), tool = new THREE.Group(), triad = makeTriad();
    solids.add(tool);
    makeBoxes(table.turning, model);
    // the path turns with the table, and stays when the machine is hidden
    const onTable = new THREE.Group(), carrier = new THREE.Group();
    carrier.matrixAutoUpdate = false;
    carrier.add(onTable);
    scene.add(carrier, marks);

    const lines = [];
    function wideLine(positions, colours, width, more) {
      const geometry = new THREE.LineGeometry();
      geometry.setPositions(positions);
      if (colours) geometry.setColors(colours);
      const line = new THREE.Line2(geometry, new THREE.LineMaterial({ linewidth: width, vertexColors: !!colours, ...more }));
      line.frustumCulled = false;
      onTable.add(line);
      lines.push(line);
      return line;
    }
    const trail = arrays["trail.tip"], count = trail.length / 3;
    const pathBox = new THREE.Box3().setFromArray(trail), size = pathBox.getSize(new THREE.Vector3()).length() || 50;
    // the path in levels of detail: without points nearer to the last one than this, mm; from afar a coarse one looks the same
    const levels = [0, size / 3000, size / 600, size / 120].map(gap => ({ gap, kept: thin(gap), line: null }));
    function thin(gap) {
      const kept = [];
      for (let k = 0, last = -1; k < count; k++) {
        const far = last < 0 || k === count - 1 || Math.hypot(trail[3 * k] - trail[3 * last], trail[3 * k + 1] - trail[3 * last + 1], trail[3 * k + 2] - trail[3 * last + 2]) >= gap;
        if (far) { kept.push(k); last = k; }
      }
      return kept;
    }
    function paint(colours) {
      for (const level of levels) {
        if (level.line) { onTable.remove(level.line); level.line.geometry.dispose(); lines.splice(lines.indexOf(level.line), 1); }
        const pick = from => Float32Array.from(level.kept.flatMap(k => [from[3 * k], from[3 * k + 1], from[3 * k + 2]]));
        level.line = level.kept.length > 1 ? wideLine(pick(trail), pick(colours), 2.6) : null;
      }
    }
    const bad = arrays["trail.bad"];
    for (let k = 0; k < count; k++) {
      if (!bad[k]) continue;
      const begin = k;
      while (k + 1 < count && bad[k + 1]) k++;
      const first = Math.max(begin - 1, 0);
      if (k > first) wideLine(trail.slice(3 * first, 3 * k + 3), null, 6, { color: COLOURS.bad });
    }
    const dots = [];
    for (let k = 0; k < arrays.worst.length; k += 3) {
      if (!Number.isFinite(arrays.worst[k])) continue;
      const dot = solid(new THREE.SphereGeometry(1, 20, 14), new THREE.MeshBasicMaterial({ color: COLOURS.bad, depthTest: false }));
      dot.renderOrder = 5;
      dot.position.set(...arrays.worst.slice(k, k + 3));
      onTable.add(dot);
      dots.push(dot);
    }
    const tip = solid(new THREE.SphereGeometry(1, 20, 14), new THREE.MeshBasicMaterial({ color: 0x111111, depthTest: false }));
    tip.renderOrder = 6;
    onTable.add(tip);
    dots.push(tip);

    // tool axes, evenly spaced over the program
    const sticks = [], step = Math.max(Math.floor(data.frames / 160), 1), length = Math.min(Math.max(0.14 * size, 6), 40);
    for (let i = 0; i < data.frames; i += step) {
      const from = arrays.tip.slice(3 * i, 3 * i + 3), axis = arrays.axis.slice(3 * i, 3 * i + 3);
      if ([...from, ...axis].every(Number.isFinite)) sticks.push(...from, ...from.map((value, k) => value + length * axis[k]));
    }
    const axes = new THREE.LineSegments(new THREE.BufferGeometry().setAttribute("position", new THREE.Float32BufferAttribute(sticks, 3)),
      new THREE.LineBasicMaterial({ color: 0x6b7580, transparent: true, opacity: 0.75 }));
    axes.frustumCulled = false;
    onTable.add(axes);

    let toolNow = "";
    function placeTool(frame) {
      const number = data.toolNumbers[arrays.tool[frame]], long = arrays.tool_length[frame], key = number + " " + long;
      if (key === toolNow) return;
      toolNow = key;
      tool.clear();
      for (const [from, to, radius] of model.tools[number] || []) {
        const end = Math.min(to === null ? long : to, long);
        if (end <= from) continue;
        const cut = to === null ? Math.min(end, from + Math.max(0.45 * (end - from), 6 * radius)) : end;
        tool.add(pillar(radius, from - long, cut - long, material("cutter")));
        if (cut < end) tool.add(pillar(Math.max(radius, 0.9 * model.spindleRadius * 0.4), cut - long, end - long, material("holder")));
      }
    }

    function orient(object, from, to, along) {
      object.position.copy(from).add(to).multiplyScalar(0.5);
      object.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), along.copy(to).sub(from).normalize());
      object.scale.z = from.distanceTo(to);
    }
    // a vector between two frames; while it plays, the machine is drawn between them
    function blend(name, i, j, share, place, width = 3) {
      const a = arrays[name], from = width * i + place, to = width * j + place;
      return new THREE.Vector3(...[0, 1, 2].map(k => a[from + k] + share * (a[to + k] - a[from + k])));
    }
    const number = (name, i, j, share) => arrays[name][i] + share * (arrays[name][j] - arrays[name][i]);
    const spare = new THREE.Vector3();
    let frameNow = 0, reached = true;

    function pose(i, j = i, share = 0) {
      frameNow = i;
      const joints = data.joints, q = k => arrays.q[joints.length * i + k];
      reached = Number.isFinite(q(0)) && Number.isFinite(arrays.tilt[i]);
      if (!reached || !Number.isFinite(arrays.tilt[j])) { j = i; share = 0; }
      const beyond = k => joints[k].low !== null && (q(k) < joints[k].low - 1e-6) || joints[k].high !== null && (q(k) > joints[k].high + 1e-6);
      if (Number.isFinite(arrays.tilt[i])) {
        table.tilting.rotation.x = number("tilt", i, j, share);
        table.turning.rotation.z = number("turn", i, j, share);
      }
      const n = joints.length;
      table.face.color.setHex(beyond(n - 2) || beyond(n - 1) ? COLOURS.bad : COLOURS.table);
      const moving = [platform, tool, ...rods.flatMap(rod => [rod.bar, ...rod.ends]), ...guides.map(guide => guide.slider)];
      for (const part of moving) part.visible = reached;
      if (reached) {
        const x = blend("basis", i, j, share, 0, 6).normalize(), z = blend("basis", i, j, share, 3, 6).normalize();
        const turn = new THREE.Matrix4().makeBasis(x, z.clone().cross(x), z);
        platform.position.copy(blend("platform", i, j, share, 0));
        platform.quaternion.setFromRotationMatrix(turn);
        tool.position.copy(blend("nose", i, j, share, 0));
        tool.quaternion.copy(platform.quaternion);
        placeTool(i);
        const starts = [];
        rods.forEach((rod, k) => {
          const a = blend("rods", i, j, share, 6 * k, 6 * rodCount), b = blend("rods", i, j, share, 6 * k + 3, 6 * rodCount);
          starts.push(a);
          orient(rod.bar, a, b, spare);
          rod.ends[0].position.copy(a);
          rod.ends[1].position.copy(b);
        });
        for (const guide of guides) {
          guide.slider.position.set(0, 0, 0);
          for (const rod of guide.rods) guide.slider.position.addScaledVector(starts[rod], 1 / guide.rods.length);
          guide.what.color.setHex(beyond(guide.joint) ? COLOURS.bad : COLOURS.slider);
        }
      }
      table.turning.updateWorldMatrix(true, false);
      carrier.matrix.copy(table.turning.matrixWorld);
      carrier.updateMatrixWorld(true);
      tip.position.copy(blend("tip", i, j, share, 0));
    }
    const tipInScene = () => tip.getWorldPosition(new THREE.Vector3());

    // what the machine fills in all its poses
    const whole = new THREE.Box3();
    const looked = new Set(data.places.filter(frame => frame >= 0));
    for (let k = 0; k <= 50 && data.frames; k++) looked.add(Math.round(k * (data.frames - 1) / 50));
    const machineBox = () => { solids.updateMatrixWorld(true); return new THREE.Box3().setFromObject(solids); };
    for (const frame of looked) { pose(frame); if (reached) whole.union(machineBox()); }
    if (whole.isEmpty()) whole.copy(machineBox());

    function corners(bounds) {
      const list = [];
      for (let k = 0; k < 8; k++) list.push(new THREE.Vector3(k & 1 ? bounds.max.x : bounds.min.x, k & 2 ? bounds.max.y : bounds.min.y, k & 4 ? bounds.max.z : bounds.min.z));
      return list;
    }
    // stand so that all points are just seen from a direction
    function frameUp(points, direction, upright = [0, 0, 1], border = 1.04) {
      camera.up.set(...upright);
      const forward = direction.clone().normalize(), centre = new THREE.Box3().setFromPoints(points).getCenter(new THREE.Vector3());
      const right = camera.up.clone().cross(forward).normalize(), up = forward.clone().cross(right);
      const high = Math.tan(THREE.MathUtils.degToRad(camera.fov / 2)) / border, wide = high * camera.aspect;
      let distance = 1;
      for (const point of points) {
        const p = point.clone().sub(centre), z = p.dot(forward);
        distance = Math.max(distance, Math.abs(p.dot(right)) / wide + z, Math.abs(p.dot(up)) / high + z);
      }
      stand(centre, forward, distance);
    }
    function stand(centre, direction, distance) {
      controls.target.copy(centre);
      camera.position.copy(centre).addScaledVector(direction, distance);
      camera.near = Math.max(distance / 500, 0.2);
      camera.far = distance + 8000;
      camera.updateProjectionMatrix();
      controls.update();
      draw();
    }
    const pathPoints = () => corners(pathBox.clone().expandByScalar(Math.max(0.08 * size, 12))).map(p => p.applyMatrix4(carrier.matrix));
    // near the path, what carries the tool is glass: it hangs over the part
    const carriers = [platform, ...rods.flatMap(rod => [rod.bar, ...rod.ends])];
    function glass(on) {
      for (const part of carriers) part.traverse(one => {
        if (!one.material) return;
        Object.assign(one.material, { transparent: on, opacity: on ? 0.16 : 1, depthWrite: !on });
      });
    }
    let through = false;
    const standBack = (direction, upright) => { through = false; frameUp(corners(whole), direction, upright); };
    const VIEWS = {
      fit: () => standBack(new THREE.Vector3(0.8, -1.3, 0.28)),
      part: () => { through = true; frameUp(pathPoints(), new THREE.Vector3(0.7, -1.2, 0.7)); },
      // looking down, y is upright until the scene is turned
      top: () => standBack(new THREE.Vector3(0, -0.0001, 1), [0, 1, 0]),
      front: () => standBack(new THREE.Vector3(0, -1, 0)),
      tool: () => standBack(reached ? blend("basis", frameNow, frameNow, 0, 3, 6).add(new THREE.Vector3(0, -0.0001, 0)) : new THREE.Vector3(0, -0.0001, 1), [0, 1, 0]),
    };
    function look() {
      through = true;
      camera.up.set(0, 0, 1);
      stand(tipInScene(), new THREE.Vector3(0.75, -1.2, 0.45).normalize(), Math.max(5 * Math.min(size, 160), 500));
    }
    function follow() {
      const step = tipInScene().sub(following.target);
      following.target.add(step);
      follower.position.add(step);
    }
    follower.position.set(0.75, -1.2, 0.6).normalize().multiplyScalar(Math.min(Math.max(2.4 * size, 240), 900));
    follower.near = 1;

    let waiting = false;
    function draw() { if (!waiting) { waiting = true; requestAnimationFrame(render); } }
    function picture(eye, seeThrough, width, height) {
      glass(seeThrough);
      // marks keep their size on the screen, and of the path there is as much as the screen shows
      const perPixel = 2 * Math.tan(THREE.MathUtils.degToRad(eye.fov / 2)) / height;
      for (const dot of dots) dot.scale.setScalar((dot === tip ? 4 : 6) * perPixel * dot.getWorldPosition(spare).distanceTo(eye.position));
      const pixel = perPixel * tip.getWorldPosition(spare).distanceTo(eye.position);
      const level = levels.filter(one => one.gap <= 0.7 * pixel).pop();
      for (const one of levels) if (one.line) one.line.visible = one === level;
      for (const line of lines) line.material.resolution.set(width, height);
      renderer.setViewport(0, 0, width, height);
      renderer.clear();
      renderer.render(scene, eye);
    }
    function render() {
      waiting = false;
      const width = canvas.clientWidth, height = canvas.clientHeight, wide = Math.min(close.clientWidth, width), high = Math.min(close.clientHeight, height);
      if (!width || !height) return;
      if (wide && high) {
        follow();
        follower.aspect = wide / high;
        follower.far = follower.position.distanceTo(following.target) + 4000;
        follower.updateProjectionMatrix();
        follower.lookAt(following.target);
        picture(follower, true, wide, high);
        const ratio = renderer.getPixelRatio(), w = Math.round(wide * ratio), h = Math.round(high * ratio);
        if (close.width !== w || close.height !== h) { close.width = w; close.height = h; }
        paper.clearRect(0, 0, w, h);
        paper.drawImage(canvas, 0, canvas.height - h, w, h, 0, 0, w, h);
      }
      picture(camera, through, width, height);
      renderer.clearDepth();
      const side = Math.min(96, 0.3 * width);
      renderer.setViewport(6, 6, side, side);
      triad.camera.position.copy(camera.position).sub(controls.target).normalize().multiplyScalar(5);
      triad.camera.up.copy(camera.up);
      triad.camera.lookAt(0, 0, 0);
      renderer.render(triad.scene, triad.camera);
    }
    function resize() {
      const width = canvas.clientWidth, height = canvas.clientHeight;
      if (!width || !height) return;
      renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
      renderer.setSize(width, height, false);
      camera.aspect = width / height;
      camera.updateProjectionMatrix();
      draw();
    }
    controls.addEventListener("change", draw);
    following.addEventListener("change", draw);
    controls.addEventListener("start", () => camera.up.set(0, 0, 1));

    // the point of the path under a place of the picture, or of the close-up; -1 where none is near
    function pick(x, y, isClose = false) {
      const [eye, element] = isClose ? [follower, close] : [camera, canvas];
      eye.updateMatrixWorld();
      const near = 14, point = new THREE.Vector3();
      let best = -1, least = near * near;
      for (let k = 0; k < count; k++) {
        point.set(trail[3 * k], trail[3 * k + 1], trail[3 * k + 2]).applyMatrix4(carrier.matrix).project(eye);
        const dx = (point.x + 1) / 2 * element.clientWidth - x, dy = (1 - point.y) / 2 * element.clientHeight - y, d = dx * dx + dy * dy;
        if (d < least) { least = d; best = k; }
      }
      return best;
    }
    // points in the canvas: -1 to 1
    function onScreen(points) {
      camera.updateMatrixWorld();
      return points.map(point => point.project(camera).toArray());
    }

    return {
      pose, draw, render, paint, resize, pick, look, camera, tipInScene, reached: () => reached,
      view: name => VIEWS[name](), show: on => { solids.visible = on; draw(); }, showAxes: on => { axes.visible = on; draw(); },
      dark: on => { tip.material.color.setHex(on ? 0xffffff : 0x111111); axes.material.color.setHex(on ? 0x9aa7b4 : 0x5a636c); draw(); },
      machineOnScreen: () => onScreen(corners(machineBox())), tipOnScreen: () => onScreen([tipInScene()])[0],
      pathOnScreen: () => onScreen(corners(pathBox).map(p => p.applyMatrix4(carrier.matrix))),
      toolEnds: () => [tool.getWorldPosition(new THREE.Vector3()).toArray(), tipInScene().toArray()],
    };
  }
  return { make };
})();
