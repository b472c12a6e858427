// The slider between camera pictures and renders.

const stemOf = name => name.split("/").at(-1).replace(/\.[^.]*$/, "");

/// What stages made under the names of recorded frames, of the stage with the most of them: {entry, views: [{name, camera, render, pose}]}.
function viewsOf(media) {
    const recorded = new Map(media.filter(entry => entry.cameras).flatMap(entry => entry.pictures ?? []).map(picture => [picture.name, picture]));
    const all = media.filter(entry => entry.folder !== undefined).map(entry => ({
        entry,
        views: (entry.pictures ?? []).filter(picture => recorded.has(stemOf(picture.name))).map(picture => {
            const { name, uri, pose } = recorded.get(stemOf(picture.name));
            return { name, camera: uri, render: picture.uri, pose };
        }),
    }));
    return all.reduce((best, each) => each.views.length > best.views.length ? each : best, { views: [] });
}

/// The slider's section. It shows the frames' pictures, which then appear nowhere else.
function compareSection(media, earlier) {
    const { views, entry } = viewsOf(media);
    const entries = media.filter(each => each.cameras || each === entry);
    if (!views.length)
        return { node: null, entries };
    const standAt = earlier.map(part => part.standAt).find(Boolean);
    const under = element("img", { alt: "camera picture" });
    const over = element("img", { class: "over", alt: "render" });
    const slider = element("input", { type: "range", min: 0, max: 100, value: 50, step: 0.1, "aria-label": "How much of the camera picture is shown", oninput: () => cut() });
    const compare = element("div", { class: "compare" }, under, over, slider, element("span", { class: "edge" }),
        element("span", { class: "tag left" }, "camera"), element("span", { class: "tag right" }, "render"));
    const caption = element("span", { id: "view-name" });
    const thumbs = views.map((view, number) => element("button", { title: view.name, onclick: () => choose(number) }, element("img", { alt: view.name, src: view.render })));
    const cut = () => compare.style.setProperty("--cut", `${slider.value}%`);
    let shown = 0;
    const choose = number => {
        shown = number;
        [under.src, over.src, caption.textContent] = [views[number].camera, views[number].render, views[number].name];
        thumbs.forEach((thumb, other) => thumb.setAttribute("aria-pressed", other === number));
    };
    choose(0);
    cut();
    const node = section("Camera and render", compare,
        element("div", { class: "bar" }, caption, standAt && element("button", { id: "stand-here", onclick: () => standAt(views[shown].pose) }, "Stand here in the room")),
        element("div", { class: "thumbs" }, thumbs), element("p", { class: "soft" }, `rendered by ${entry.stage}`));
    return { node, entries };
}

(globalThis.viewerParts ??= []).push({ place: 2, make: (data, media, earlier) => compareSection(media, earlier) });
