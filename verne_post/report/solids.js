// The solids of the machine, in mm, z up: table, guides, platform with spindle, rods, fixtures and stock, and the triad of the axes.
const Solids = (() => {
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

  // what carries the part: a round table, or a bed under a part that stands; on a trunnion, on a foot, or on the floor
  function makeTable(scene, model) {
    const bed = model.bed, r = bed ? Math.max(...bed.half) : model.radius;
    const group = new THREE.Group(), tilting = new THREE.Group(), turning = new THREE.Group(), part = new THREE.Group();
    const face = material("table"), cradle = material("cradle"), base = material("base"), tiltAxis = vector(model.tiltAxis);
    if (bed) {
      const [x, y] = bed.half, [, , top] = bed.middle, plate = box(2 * x, 2 * y, 40, face);
      plate.position.set(bed.middle[0], bed.middle[1], top - 20);
      part.add(plate);
      for (let k = -1; k <= 1; k++) {
        const groove = box(1.96 * x, 10, 2, material("groove"));
        groove.position.set(bed.middle[0], bed.middle[1] + k * y / 2, top - 0.6);
        part.add(groove);
      }
    } else {
      part.add(pillar(r, -32, 0, face, r, 64), pillar(0.45 * r, -80, -32, cradle));
      for (let k = 0; k < 4; k++) {
        const groove = box(1.9 * r, 10, 2, material("groove"));
        groove.rotation.z = k * Math.PI / 4;
        groove.position.z = -0.6;
        part.add(groove);
      }
      const marker = box(0.3 * r, 16, 2, material("nose"));
      marker.position.set(0.8 * r, 0, -0.4);
      part.add(marker);
    }
    part.position.copy(vector(model.part));
    turning.position.copy(vector(model.offset));
    turning.add(part);
    tilting.add(turning);
    group.add(tilting);
    const floor = box(2 * r + 320, 2 * r + 160, 24, base);
    if (model.carries === 2 && Math.abs(tiltAxis.z) < 0.1) {
      const trunnion = new THREE.Group(), stand = new THREE.Group(), yoke = box(2 * r + 90, 0.7 * r, 40, cradle);
      yoke.position.z = -105;
      trunnion.add(yoke);
      for (const side of [-1, 1]) {
        const arm = box(24, 0.5 * r, 150, cradle), pin = pillar(32, -30, 30, material("nose")), post = box(44, 0.6 * r, r + 190, base);
        arm.position.set(side * (r + 34), 0, -55);
        pin.rotation.y = Math.PI / 2;
        pin.position.set(side * (r + 60), 0, 0);
        post.position.set(side * (r + 84), 0, 40 - (r + 190) / 2);
        trunnion.add(arm, pin);
        stand.add(post);
      }
      floor.position.z = -(r + 162);
      stand.add(floor);
      trunnion.rotation.z = stand.rotation.z = Math.atan2(tiltAxis.y, tiltAxis.x);
      tilting.add(trunnion);
      group.add(stand);
    } else if (model.carries === 2) {
      // an axis that is neither level nor upright: its bearing is below the table
      const down = tiltAxis.clone().multiplyScalar(tiltAxis.z > 0 ? -1 : 1), bearing = pillar(0.4 * r, 0.6 * r, 1.3 * r, cradle);
      const spin = new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 0, 1), down), block = pillar(0.6 * r, 1.3 * r, 1.6 * r, base);
      for (const mesh of [bearing, block]) {
        mesh.quaternion.copy(spin);
        mesh.position.applyQuaternion(spin);
        group.add(mesh);
      }
    } else if (model.carries === 1) {
      floor.position.copy(vector(model.offset)).add(vector(model.part));
      floor.position.z -= 92;
      group.add(floor);
    }
    group.position.copy(vector(model.pivot));
    scene.add(group);
    return { tilting, turning, part, face, tiltAxis, turnAxis: vector(model.turnAxis) };
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
      group.add(makePlate(outline(model.joints), height, body));
    }
    const r = model.spindleRadius;
    group.add(pillar(r, 30, model.spindleTop, material("spindle")), pillar(0.6 * r, 0, 30, material("nose"), r));
    scene.add(group);
    return group;
  }

  function makePlate(outlined, height, what) {
    const shape = new THREE.Shape(outlined.map(p => new THREE.Vector2(p[0], p[1])));
    const plate = solid(new THREE.ExtrudeGeometry(shape, { depth: 34, bevelEnabled: true, bevelSize: 18, bevelThickness: 4, bevelSegments: 2 }), what);
    plate.position.z = height - 17;
    return plate;
  }

  // a plate between rods that is not the spindle's; how it stands follows from their ends
  function makeOwnPlate(scene, model) {
    const group = new THREE.Group();
    if (model.plate.length) group.add(makePlate(outline(model.plate), 0, material("platform")));
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

  // also returns the solids of the stock
  function makeBoxes(part, model) {
    const stock = [];
    for (const one of model.boxes) {
      const what = one.stock ? material("stock", { transparent: true, opacity: 0.4, depthWrite: false }) : material("fixture", { transparent: true, opacity: 0.85 });
      const mesh = one.round ? tube(one.half[0], one.bore, 2 * one.half[2], what) : box(...one.half.map(half => 2 * half), what);
      mesh.position.copy(vector(one.middle));
      mesh.rotation.z = one.turn;
      const edges = new THREE.LineSegments(new THREE.EdgesGeometry(mesh.geometry), new THREE.LineBasicMaterial({ color: one.stock ? 0x9a6527 : 0x1f5f56 }));
      mesh.add(edges);
      part.add(mesh);
      mesh.updateMatrix();
      mesh.geometry.computeBoundingBox();
      if (one.stock) stock.push(mesh);
    }
    return stock;
  }

  // triangles with sharp edges, from packed vertices and facets
  function makeMesh(one, vertex, facet, what) {
    const place = new Float32Array(3 * facet.length);
    facet.forEach((v, k) => { for (let c = 0; c < 3; c++) place[3 * k + c] = one.low[c] + one.step * vertex[3 * v + c]; });
    const geometry = new THREE.BufferGeometry().setAttribute("position", new THREE.BufferAttribute(place, 3));
    geometry.computeVertexNormals();
    const mesh = solid(geometry, what);
    mesh.position.copy(vector(one.middle));
    mesh.rotation.z = one.turn;
    return mesh;
  }

  // also returns the nominal part and what is left of the stock
  function makeMeshes(part, model, arrays) {
    const bodies = {};
    model.meshes.forEach((one, k) => {
      const fixed = one.kind === "fixture", colour = arrays[`surface.${k}.colour`];
      const what = fixed ? material("fixture", { transparent: true, opacity: 0.85 })
        : colour ? new THREE.MeshLambertMaterial({ vertexColors: true, side: THREE.DoubleSide }) : material("stock", { side: THREE.DoubleSide });
      const mesh = makeMesh(one, arrays[`surface.${k}.vertex`], arrays[`surface.${k}.facet`], what);
      if (fixed) mesh.add(new THREE.LineSegments(new THREE.EdgesGeometry(mesh.geometry, 20), new THREE.LineBasicMaterial({ color: 0x1f5f56 })));
      else bodies[one.kind] = { mesh, value: arrays[`surface.${k}.value`], frame: arrays[`surface.${k}.frame`] };
      if (colour) {
        const corner = new Uint8Array(3 * colour.length);
        for (let f = 0; f < colour.length; f += 3) for (let c = 0; c < 9; c++) corner[3 * f + c] = colour[f + c % 3];
        mesh.geometry.setAttribute("color", new THREE.BufferAttribute(corner, 3, true));
      }
      part.add(mesh);
    });
    return bodies;
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

  return { COLOURS, material, solid, pillar, makeTable, makeGuides, makePlatform, makeOwnPlate, makeRods, makeBoxes, makeMeshes, makeTriad };
})();
