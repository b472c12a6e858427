// The section with the room, which plugins/shared/page draws.

/// Which way is up, as the last stage found that reported it; undefined where none did.
const upOf = stages => stages.map(stage => stage.figures.up).filter(Array.isArray).at(-1);

/// Sliders for the shares of a mixture, and the line that brings them into the pipeline. `mix`: draws the room with a share.
function mixtureBar(stage, mixture, mix) {
    const shares = { color: mixture.color, strokes: mixture.strokes };
    const line = element("code", { id: "shares" });
    const tell = () => line.textContent = `${stage}: {color: ${shares.color}, strokes: ${shares.strokes}}`;
    tell();
    const slider = name => element("label", {}, `${name} `, element("input", {
        type: "range", min: 0, max: 1, step: 0.01, value: shares[name], id: `mix-${name}`,
        oninput: event => {
            shares[name] = Number(event.target.value);
            mix(name, shares[name]);
            tell();
        },
    }));
    return element("div", { class: "bar" }, slider("color"), slider("strokes"), line);
}

/// The room's section, and what puts the visitor to a pose.
function roomSection(data, media) {
    const entry = media.filter(each => each.room).at(-1);
    if (!entry)
        return { node: null };
    if (typeof THREE === "undefined")
        return { node: section("The room", element("p", { class: "note" }, "To turn the room around here, build fresco where three.js is (Debian's libjs-three).")) };
    const frames = media.filter(each => each.cameras);
    const cameras = (frames.filter(each => each.pictures).at(-1) ?? frames.at(-1))?.cameras;
    const mixed = media.filter(each => each.mixture && each.mixture.atlas === entry.room.atlas).at(-1);
    const relief = media.filter(each => each.relief && each.relief.atlas === entry.room.atlas).at(-1)?.relief;
    const place = element("div", { id: "room" });
    let shown = null;
    const start = () => showRoom(place, entry.room, { mixture: mixed?.mixture, relief, cameras, up: upOf(data.stages) }).then(room => shown = room).catch(error =>
        place.replaceChildren(element("p", { class: "hint" }, `The room cannot be shown here: ${error.message}`)));
    const { triangles, extent } = entry.room;
    const node = section("The room", place, mixed && mixtureBar(mixed.stage, mixed.mixture, (name, share) => shown?.mix(name, share)), element("div", { class: "bar" },
        element("button", { id: "inside", onclick: () => shown?.walk() }, "Walk inside"),
        element("button", { id: "outside", onclick: () => shown?.orbit() }, "Look from outside"),
        relief && !mixed ? element("button", { id: "light", onclick: () => shown?.light() }, "Move the light") : null,
        element("span", { class: "soft" }, `${figureText(triangles)} faces of ${entry.stage}, positions to ${figureText(Number((1000 * Math.max(...extent) / 65535).toPrecision(2)))} mm`)));
    const standAt = pose => {
        shown?.standAt(pose);
        place.scrollIntoView({ block: "center" });
    };
    return { node, standAt, start };
}

(globalThis.viewerParts ??= []).push({ place: 1, make: roomSection });
