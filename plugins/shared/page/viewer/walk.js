// Walking through the room: where one can stand, and how keys, mouse and fingers lead there.

const cell_m = 0.08;
const reach_m = 0.22;  // What the eye keeps from walls.

/// A view of the room from above as a grid: walls from `below` meters under the eye on, and what there is to stand above. `triangles(visit)` calls
/// visit(a, b, c) with points [east, north, up], which are others at the next call; `low`, `high`: the box to look at, [east, north].
function planOf(triangles, low, high, eye, below = 0.35) {
    const [columns, rows] = [0, 1].map(axis => 1 + Math.floor((high[axis] - low[axis]) / cell_m));
    const wall = new Uint8Array(columns * rows), ground = new Uint8Array(columns * rows);
    const mark = (grid, east, north) => {
        const [column, row] = [Math.floor((east - low[0]) / cell_m), Math.floor((north - low[1]) / cell_m)];
        if (column >= 0 && row >= 0 && column < columns && row < rows)
            grid[row * columns + column] = 1;
    };
    const length = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
    triangles((a, b, c) => {
        if (Math.min(a[2], b[2], c[2]) > eye + 0.15)
            return;
        const steps = Math.min(400, Math.ceil(Math.max(length(a, b), length(b, c), length(c, a)) / (0.7 * cell_m)));
        for (let i = 0; i <= steps; ++i)
            for (let j = 0; j <= steps - i; ++j) {
                const u = steps ? i / steps : 0, v = steps ? j / steps : 0;
                const at = axis => a[axis] + u * (b[axis] - a[axis]) + v * (c[axis] - a[axis]);
                if (at(2) < eye + 0.15)
                    mark(at(2) < eye - below ? ground : wall, at(0), at(1));
            }
    });
    return { low, columns, rows, walls: distancesTo(wall, columns, rows), grounds: distancesTo(ground, columns, rows) };
}

/// Of each cell to the next marked one, in meters, along straight and diagonal steps; Infinity without any.
function distancesTo(marked, columns, rows) {
    const found = Float32Array.from(marked, is => is ? 0 : Infinity);
    const pass = (first, step, around) => {
        for (let i = 0, cell = first; i < found.length; ++i, cell += step) {
            const column = cell % columns;
            for (const [dx, dy, far] of around) {
                const other = cell + dy * columns + dx;
                if (column + dx >= 0 && column + dx < columns && other >= 0 && other < found.length)
                    found[cell] = Math.min(found[cell], found[other] + far * cell_m);
            }
        }
    };
    pass(0, 1, [[-1, 0, 1], [0, -1, 1], [-1, -1, Math.SQRT2], [1, -1, Math.SQRT2]]);
    pass(found.length - 1, -1, [[1, 0, 1], [0, 1, 1], [1, 1, Math.SQRT2], [-1, 1, Math.SQRT2]]);
    return found;
}

const cellAt = (plan, east, north) => [Math.floor((east - plan.low[0]) / cell_m), Math.floor((north - plan.low[1]) / cell_m)];

/// How good a place is to stand on: at least 0 where one may, and the larger the farther from walls and from the end of what was scanned.
/// Cameras may have stood outside of what they saw: the way back to it leads up.
function roomAt(plan, east, north) {
    const [column, row] = cellAt(plan, east, north);
    const beyond = Math.hypot(Math.max(0, -column, column - plan.columns + 1), Math.max(0, -row, row - plan.rows + 1));
    const cell = row * plan.columns + column;
    return beyond ? -100 - beyond : Math.max(-100, Math.min(plan.walls[cell] - reach_m, 0.6 - plan.grounds[cell]));
}

/// A step, as far as it stays inside: along a wall where it leads into one. From a place that is too near to a wall it leads no nearer.
function stepFrom(plan, [east, north], [de, dn]) {
    const here = roomAt(plan, east, north);
    for (const [e, n] of [[de, dn], [de, 0], [0, dn]]) {
        const there = roomAt(plan, east + e, north + n);
        if ((e || n) && (there >= 0 || there >= here))
            return [east + e, north + n];
    }
    return [east, north];
}

/// The widest place of the plan, [east, north], and the direction of the longest view of walls from there, in radians; null: there is none.
function widestPlace(plan) {
    const { columns, rows } = plan;
    const ends = distancesTo(plan.grounds.map((far, cell) => far > 0.3 || cell % columns === 0 || cell % columns === columns - 1 || cell < columns || cell >= columns * (rows - 1)), columns, rows);
    let best = -1, most = 0;
    ends.forEach((end, cell) => {
        if (Math.min(end, plan.walls[cell]) > most)
            [best, most] = [cell, Math.min(end, plan.walls[cell])];
    });
    if (best < 0)
        return null;
    const place = [best % plan.columns, Math.floor(best / plan.columns)].map((at, axis) => plan.low[axis] + (at + 0.5) * cell_m);
    const to_wall = Array.from({ length: 32 }, (_, i) => {
        for (let far = cell_m; ; far += cell_m) {
            const [column, row] = cellAt(plan, place[0] + far * Math.cos(i * Math.PI / 16), place[1] + far * Math.sin(i * Math.PI / 16));
            if (column < 0 || row < 0 || column >= columns || row >= rows)
                return 0;  // Nothing was scanned there.
            if (plan.walls[row * columns + column] < cell_m)
                return far;
        }
    });
    // A crumb behind a gap is no view: what is beside the direction counts, too.
    const views = to_wall.map((far, i) => [-2, -1, 0, 1, 2].reduce((sum, aside) => sum + Math.min(far, to_wall.at((i + aside) % 32)), 0));
    return { place, angle: views.indexOf(Math.max(...views)) * Math.PI / 16 };
}

/// The height that most of the surface has which faces up, of the lower half of the room. `triangles` as for planOf; `low`, `high`: heights.
function floorOf(triangles, low, high) {
    const bins = new Float64Array(200), size = Math.max(high - low, 1e-6) / 200;
    triangles((a, b, c) => {
        const area = ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2;
        const [bottom, top] = [Math.min(a[2], b[2], c[2]), Math.max(a[2], b[2], c[2])];
        if (area > 0 && top - bottom < Math.sqrt(area))
            bins[Math.max(0, Math.min(199, Math.floor(((bottom + top) / 2 - low) / size)))] += area;
    });
    const smooth = Array.from({ length: 100 }, (_, i) => (bins[i - 1] ?? 0) + bins[i] + bins[i + 1]);
    const most = Math.max(...smooth);
    const lowest = smooth.findIndex(area => area > 0.3 * most);
    const best = smooth[lowest + 1] > smooth[lowest] ? lowest + 1 : lowest;
    return low + (best + 0.5) * size;
}

/// Turns and moves as one walks: `walker` has turn(dx, dy) in pixels, walk(ahead, aside) in meters, and enabled(). Keys only while the
/// canvas has the focus.
function walkingControls(canvas, walker) {
    const pointers = new Map();
    const held = new Set();
    const ways = { KeyW: [1, 0], ArrowUp: [1, 0], KeyS: [-1, 0], ArrowDown: [-1, 0], KeyA: [0, -1], KeyD: [0, 1], ArrowLeft: [0, 0, -1], ArrowRight: [0, 0, 1], KeyQ: [0, 0, -1], KeyE: [0, 0, 1] };
    let last = null;  // When it last moved; null: no key is held.
    const move = seconds => {
        const [ahead, aside, around] = [0, 1, 2].map(part => Array.from(held, key => ways[key][part] ?? 0).reduce((a, b) => a + b, 0));
        if (ahead || aside)
            walker.walk(1.6 * seconds * ahead, 1.6 * seconds * aside);
        if (around)
            walker.turn(-450 * seconds * around, 0);
    };
    const go = time => {
        if (last !== null)
            move(Math.min(0.1, Math.max(0, time - last) / 1000));
        last = held.size && walker.enabled() ? time : null;
        if (last !== null)
            requestAnimationFrame(go);
    };
    canvas.addEventListener("keydown", event => {
        if (!walker.enabled() || !ways[event.code] || event.ctrlKey || event.altKey || event.metaKey)
            return;
        event.preventDefault();
        if (held.has(event.code))
            return;
        held.add(event.code);
        move(0.03);  // A tap may be over before the next frame.
        if (last === null) {
            last = performance.now();
            requestAnimationFrame(go);
        }
    });
    canvas.addEventListener("keyup", event => held.delete(event.code));
    canvas.addEventListener("blur", () => held.clear());
    canvas.addEventListener("pointerdown", event => {
        pointers.set(event.pointerId, [event.clientX, event.clientY]);
        canvas.setPointerCapture(event.pointerId);
    });
    const middle = () => [0, 1].map(axis => Array.from(pointers.values(), at => at[axis]).reduce((a, b) => a + b, 0) / pointers.size);
    const spread = () => {
        const [a, b] = pointers.values();
        return Math.hypot(a[0] - b[0], a[1] - b[1]);
    };
    canvas.addEventListener("pointermove", event => {
        if (!pointers.has(event.pointerId))
            return;
        const [before, wide] = [middle(), pointers.size === 2 ? spread() : 0];
        pointers.set(event.pointerId, [event.clientX, event.clientY]);
        const [dx, dy] = middle().map((at, axis) => at - before[axis]);
        if (!walker.enabled())
            return;
        if (pointers.size === 1)
            walker.turn(dx, dy);
        else if (pointers.size === 2)
            walker.walk(0.012 * (spread() - wide - dy), 0.012 * dx);
    });
    for (const name of ["pointerup", "pointercancel"])
        canvas.addEventListener(name, event => pointers.delete(event.pointerId));
    canvas.addEventListener("wheel", event => {
        if (!walker.enabled())
            return;
        event.preventDefault();
        walker.walk(-0.003 * Math.max(-200, Math.min(200, event.deltaY)), 0);
    }, { passive: false });
}
