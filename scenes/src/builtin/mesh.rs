//! A mesh builder: parametric patches and the solids made of them, with texture coordinates in
//! world units, and the rubble that brings a scene to an exact number of triangles.

use std::f32::consts::TAU;

use glam::{Affine3A, Quat, Vec2, Vec3, vec2, vec3};
use saarcor_model::host::Triangle;
use saarcor_random::Random;

/// What a piece of mesh is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Index into the scene's materials.
    pub material: u32,
    /// World units that one tile of the material's images covers, in both directions.
    pub tile: f32,
}

/// A point of a [`Mesh::patch`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// Position in the mesh's space.
    pub position: Vec3,
    /// Distance along the surface in world units, to the right and upwards.
    pub along: Vec2,
}

/// Triangles under construction.
///
/// Every primitive leaves out triangles without area, so a patch may collapse to a point at a pole.
/// Fronts face outwards; where a primitive says nothing else, a larger `cells` or `sides` only
/// makes it finer.
#[derive(Clone, Debug)]
pub struct Mesh {
    triangles: Vec<Triangle>,
    tex_coords: Vec<[Vec2; 3]>,
    textured: bool,
}

impl Mesh {
    /// An empty mesh, which keeps texture coordinates only if `textured`.
    #[must_use]
    pub fn new(textured: bool) -> Self {
        Self { triangles: Vec::new(), tex_coords: Vec::new(), textured }
    }

    /// The number of triangles.
    #[must_use]
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// True if the mesh keeps texture coordinates.
    #[must_use]
    pub fn is_textured(&self) -> bool {
        self.textured
    }

    /// The triangles and the texture coordinates of their corners; the latter are empty unless the
    /// mesh is textured.
    #[must_use]
    pub fn into_parts(self) -> (Vec<Triangle>, Vec<[Vec2; 3]>) {
        (self.triangles, self.tex_coords)
    }

    /// Adds a triangle, counter-clockwise seen from the front, unless it has no area.
    pub fn triangle(&mut self, surface: Surface, corners: [Vertex; 3]) {
        self.push(
            Triangle { corners: corners.map(|c| c.position), material: surface.material },
            corners.map(|c| c.along / surface.tile),
        );
    }

    fn push(&mut self, triangle: Triangle, tex_coords: [Vec2; 3]) {
        if triangle.is_degenerate() {
            return;
        }
        self.triangles.push(triangle);
        if self.textured {
            self.tex_coords.push(tex_coords);
        }
    }

    /// Adds another mesh, moved by `transform`. A transform that mirrors turns fronts to backs.
    pub fn append(&mut self, other: &Self, transform: Affine3A) {
        for (i, triangle) in other.triangles.iter().enumerate() {
            let corners = triangle.corners.map(|c| transform.transform_point3(c));
            let tex_coords = other.tex_coords.get(i).copied().unwrap_or_default();
            self.push(Triangle { corners, ..*triangle }, tex_coords);
        }
    }

    /// Adds the surface `at(u, v)`, u and v from 0 to 1, as `cells[0] × cells[1]` cells of two
    /// triangles. The front is where u runs to the right and v upwards.
    pub fn patch(&mut self, surface: Surface, cells: [u32; 2], at: impl Fn(f32, f32) -> Vertex) {
        let row = |j: u32| -> Vec<Vertex> {
            let v = j as f32 / cells[1] as f32;
            (0..=cells[0]).map(|i| at(i as f32 / cells[0] as f32, v)).collect()
        };
        let mut below = row(0);
        for j in 1..=cells[1] {
            let above = row(j);
            for (lower, upper) in below.windows(2).zip(above.windows(2)) {
                self.triangle(surface, [lower[0], lower[1], upper[1]]);
                self.triangle(surface, [lower[0], upper[1], upper[0]]);
            }
            below = above;
        }
    }

    /// Adds a parallelogram from `origin` along `right` and `up`, in cells no longer than `cell`.
    pub fn quad(&mut self, surface: Surface, origin: Vec3, right: Vec3, up: Vec3, cell: f32) {
        let size = vec2(right.length(), up.length());
        let cells = [cells_along(size.x, cell), cells_along(size.y, cell)];
        self.patch(surface, cells, |u, v| Vertex {
            position: origin + right * u + up * v,
            along: vec2(u, v) * size,
        });
    }

    /// Adds a rectangle like [`Mesh::quad`] without its holes: pairs of opposite corners, each a
    /// distance along `right` and along `up`. Edges of holes cut the whole rectangle.
    pub fn pierced_quad(
        &mut self,
        surface: Surface,
        [origin, right, up]: [Vec3; 3],
        holes: &[(Vec2, Vec2)],
        cell: f32,
    ) {
        let size = vec2(right.length(), up.length());
        let cuts = |length: f32, ends: fn(&(Vec2, Vec2)) -> [f32; 2]| {
            let cells = cells_along(length, cell);
            let mut cuts: Vec<f32> = (0..=cells).map(|i| length * i as f32 / cells as f32).collect();
            cuts.extend(holes.iter().flat_map(ends).filter(|&cut| 0.0 < cut && cut < length));
            cuts.sort_by(f32::total_cmp);
            cuts.dedup();
            cuts
        };
        let columns = cuts(size.x, |(a, b)| [a.x, b.x]);
        let rows = cuts(size.y, |(a, b)| [a.y, b.y]);
        for y in rows.windows(2) {
            for x in columns.windows(2) {
                let (low, high) = (vec2(x[0], y[0]), vec2(x[1], y[1]));
                let middle = (low + high) / 2.0;
                let in_hole =
                    |&(a, b): &(Vec2, Vec2)| a.min(b).cmplt(middle).all() && middle.cmplt(a.max(b)).all();
                if holes.iter().any(in_hole) {
                    continue;
                }
                self.patch(surface, [1, 1], |u, v| {
                    let along = low + (high - low) * vec2(u, v);
                    let part = along / size;
                    Vertex { position: origin + right * part.x + up * part.y, along }
                });
            }
        }
    }

    /// Adds the six faces of the box from `min` to `max`, in cells no longer than `cell`.
    pub fn cuboid(&mut self, surface: Surface, min: Vec3, max: Vec3, cell: f32) {
        let size = max - min;
        let [x, y, z] = [Vec3::X * size, Vec3::Y * size, Vec3::Z * size];
        self.quad(surface, min + z, x, y, cell);
        self.quad(surface, min + x, -x, y, cell);
        self.quad(surface, min, z, y, cell);
        self.quad(surface, min + x + z, -z, y, cell);
        self.quad(surface, min + y + z, x, -z, cell);
        self.quad(surface, min, x, z, cell);
    }

    /// Adds the box from `min` to `max` with its edges rounded to `radius`, at most half the least
    /// side: `arc` cells from a face to the middle of an edge and `flat` cells along the rest of each axis.
    pub fn rounded_cuboid(
        &mut self,
        surface: Surface,
        [min, max]: [Vec3; 2],
        radius: f32,
        arc: u32,
        flat: [u32; 3],
    ) {
        // Along an axis: the centre of the rounding, and where from it the surface lies, as the
        // coordinate on a cube around it.
        let stops: [Vec<(f32, f32)>; 3] = [0, 1, 2].map(|axis| {
            let (low, high) = (min[axis] + radius, max[axis] - radius);
            // Exactly 1 at an edge of the cube, so that its two faces meet.
            let tan = |i: u32| if i == arc { 1.0 } else { libm::tanf(TAU / 8.0 * i as f32 / arc as f32) };
            let mut stops: Vec<_> = (1..=arc).rev().map(|i| (low, -tan(i))).collect();
            stops.extend((0..=flat[axis]).map(|i| (low + (high - low) * i as f32 / flat[axis] as f32, 0.0)));
            stops.extend((1..=arc).map(|i| (high, tan(i))));
            stops
        });
        for normal in 0..3 {
            let (right, up) = ((normal + 1) % 3, (normal + 2) % 3);
            let cells = [right, up].map(|axis| stops[axis].len() as u32 - 1);
            for high in [false, true] {
                self.patch(surface, cells, |u, v| {
                    let u = if high { u } else { 1.0 - u };
                    let (mut centre, mut offset) = (Vec3::ZERO, Vec3::ZERO);
                    let ends = (stops[normal][0], stops[normal][stops[normal].len() - 1]);
                    (centre[normal], offset[normal]) = if high { (ends.1.0, 1.0) } else { (ends.0.0, -1.0) };
                    let nearest = |t: f32, cells: u32| (t * cells as f32).round() as usize;
                    (centre[right], offset[right]) = stops[right][nearest(u, cells[0])];
                    (centre[up], offset[up]) = stops[up][nearest(v, cells[1])];
                    let position = centre + offset.normalize() * radius;
                    Vertex { position, along: vec2(position[right], position[up]) }
                });
            }
        }
    }

    /// The mesh with every corner moved to where `to` says.
    #[must_use]
    pub fn bent(&self, to: impl Fn(Vec3) -> Vec3) -> Self {
        let mut bent = Self::new(self.textured);
        for (i, triangle) in self.triangles.iter().enumerate() {
            let tex_coords = self.tex_coords.get(i).copied().unwrap_or_default();
            bent.push(Triangle { corners: triangle.corners.map(&to), ..*triangle }, tex_coords);
        }
        bent
    }

    /// Adds the side of a cylinder or cone between two ends, each a centre and a radius, of `sides`
    /// sides and `rings` rings. [`Mesh::disc`] closes an end.
    pub fn cylinder(&mut self, surface: Surface, ends: [(Vec3, f32); 2], sides: u32, rings: u32) {
        let [(from, from_radius), (to, to_radius)] = ends;
        let axis = to - from;
        let (right, front) = axis.normalize_or(Vec3::Y).any_orthonormal_pair();
        let (length, girth) = (axis.length(), TAU * from_radius.max(to_radius));
        self.patch(surface, [sides, rings], |u, v| {
            // Exact at both ends, so that a disc of the same radius fits.
            let turn = circle(u) * (from_radius * (1.0 - v) + to_radius * v);
            Vertex {
                position: from.lerp(to, v) + right * turn.x + front * turn.y,
                along: vec2(u * girth, v * length),
            }
        });
    }

    /// Adds a disc that faces along the unit vector `normal`, of `sides` triangles.
    pub fn disc(&mut self, surface: Surface, centre: Vec3, normal: Vec3, radius: f32, sides: u32) {
        self.fan(surface, (centre, radius), normal.any_orthonormal_pair(), sides, 1.0);
    }

    /// Adds a cylinder or cone with both ends closed: a prism where `sides` is small.
    pub fn closed_cylinder(&mut self, surface: Surface, ends: [(Vec3, f32); 2], sides: u32, rings: u32) {
        let axis = (ends[1].0 - ends[0].0).normalize_or(Vec3::Y);
        self.cylinder(surface, ends, sides, rings);
        let (right, front) = axis.any_orthonormal_pair();
        self.fan(surface, ends[0], (right, front), sides, 0.0);
        self.fan(surface, ends[1], (right, front), sides, 1.0);
    }

    /// Adds a disc of `sides` triangles in the plane of two axes. With `rim` = 1 it runs from the rim
    /// to the centre and faces where the first axis turns to the second counter-clockwise; with
    /// `rim` = 0 it runs outwards and faces the other way, with the very same points.
    fn fan(
        &mut self,
        surface: Surface,
        (centre, radius): (Vec3, f32),
        (right, front): (Vec3, Vec3),
        sides: u32,
        rim: f32,
    ) {
        self.patch(surface, [sides, 1], |u, v| {
            let turn = circle(u) * radius * (rim - v).abs();
            Vertex { position: centre + right * turn.x + front * turn.y, along: turn }
        });
    }

    /// Adds a sphere of `sides` meridians and `rings` rings from pole to pole along y.
    pub fn sphere(&mut self, surface: Surface, centre: Vec3, radius: f32, sides: u32, rings: u32) {
        self.patch(surface, [sides, rings], |u, v| {
            let turn = circle(-u);
            let height = circle(0.75 - 0.5 * v).y;
            let around = (1.0 - height * height).max(0.0).sqrt();
            Vertex {
                position: centre + vec3(turn.x * around, height, turn.y * around) * radius,
                along: vec2(u * TAU, v * TAU / 2.0) * radius,
            }
        });
    }

    /// Adds a tube of constant `radius` around the line through `points`, open at both ends.
    pub fn tube(&mut self, surface: Surface, points: &[Vec3], radius: f32, sides: u32) {
        let Some(last) = points.len().checked_sub(1).filter(|&last| last > 0) else { return };
        let mut right = (points[1] - points[0]).any_orthonormal_vector();
        let mut length = 0.0;
        let rings: Vec<(Vec3, Vec3, Vec3, f32)> = (0..=last)
            .map(|i| {
                let dir = (points[(i + 1).min(last)] - points[i.saturating_sub(1)]).normalize();
                right = right.reject_from_normalized(dir).normalize();
                length += points[i].distance(points[i.saturating_sub(1)]);
                (points[i], right, dir.cross(right), length)
            })
            .collect();
        self.patch(surface, [sides, last as u32], |u, v| {
            let (centre, right, front, length) = rings[(v * last as f32).round() as usize];
            let turn = circle(u) * radius;
            Vertex {
                position: centre + right * turn.x + front * turn.y,
                along: vec2(u * TAU * radius, length),
            }
        });
    }

    /// Adds a torus about the z axis of `turn`: radii and numbers of cells around the ring and the
    /// tube.
    pub fn torus(
        &mut self,
        surface: Surface,
        centre: Vec3,
        turn: Quat,
        [radius, thickness]: [f32; 2],
        cells: [u32; 2],
    ) {
        self.patch(surface, cells, |u, v| {
            let (around, tube) = (circle(u), circle(v));
            let reach = radius + thickness * tube.x;
            let position = vec3(around.x * reach, around.y * reach, thickness * tube.y);
            Vertex { position: centre + turn * position, along: vec2(u * radius, v * thickness) * TAU }
        });
    }

    /// Adds a surface of revolution about the y axis: `profile` holds radius and height from the
    /// bottom to the top.
    pub fn lathe(&mut self, surface: Surface, profile: &[Vec2], sides: u32) {
        let Some(last) = profile.len().checked_sub(1).filter(|&last| last > 0) else { return };
        let mut length = 0.0;
        let lengths: Vec<f32> = (0..=last)
            .map(|i| {
                length += profile[i].distance(profile[i.saturating_sub(1)]);
                length
            })
            .collect();
        let girth = TAU * profile.iter().fold(0.0_f32, |widest, p| widest.max(p.x));
        self.patch(surface, [sides, last as u32], |u, v| {
            let i = (v * last as f32).round() as usize;
            let turn = circle(-u) * profile[i].x;
            Vertex { position: vec3(turn.x, profile[i].y, turn.y), along: vec2(u * girth, lengths[i]) }
        });
    }

    /// Adds stones of exactly `count` triangles in all, none if `count` is under three.
    ///
    /// A stone is an irregular dome of about one unit, open below, where `place` says: it lies on
    /// a floor at y = 0 before that. With 15 to 27 triangles a stone, and a last one that takes any
    /// number that is left, this is the detail that brings a scene to its exact size.
    pub fn rubble(
        &mut self,
        surface: Surface,
        count: usize,
        random: &mut Random,
        mut place: impl FnMut(&mut Random) -> Affine3A,
    ) {
        const MAX_SIDES: u32 = 9;
        let mut left = count;
        while left >= 3 {
            let sides = random.range(5, MAX_SIDES + 1);
            // Room for this stone and a cone of at least three sides after it, or else the cone.
            let (sides, shoulder) =
                if left >= 3 * sides as usize + 3 { (sides, true) } else { (left as u32, false) };
            let height = random.between(0.35, 0.6);
            let foot: Vec<Vec2> =
                (0..sides).map(|i| circle(i as f32 / sides as f32) * random.between(0.4, 0.55)).collect();
            let mut stone = Self::new(self.textured);
            let ring = |scale: f32, y: f32, u: f32| {
                let p = foot[(u * sides as f32).round() as usize % sides as usize] * scale;
                Vertex { position: vec3(p.x, y, -p.y), along: vec2(p.x, p.y) }
            };
            if shoulder {
                stone.patch(surface, [sides, 2], |u, v| match v {
                    0.0 => ring(1.0, 0.0, u),
                    1.0 => ring(0.0, height, u),
                    _ => ring(0.8, height * 0.7, u),
                });
            } else {
                stone.patch(surface, [sides, 1], |u, v| ring(1.0 - v, height * v, u));
            }
            left -= stone.len();
            let before = self.len();
            self.append(&stone, place(random));
            debug_assert_eq!(self.len() - before, stone.len(), "a stone that was placed has area");
        }
    }
}

/// The line through `points` with its corners rounded: each becomes a parabola of `cells` pieces
/// that starts `radius` before it, or halfway to its neighbour where that is nearer.
#[must_use]
pub fn rounded_line(points: &[Vec3], radius: f32, cells: u32) -> Vec<Vec3> {
    let mut line: Vec<Vec3> = points.first().copied().into_iter().collect();
    for corner in points.windows(3) {
        let towards = |to: Vec3| {
            let way = to - corner[1];
            corner[1] + way * (radius / way.length()).min(0.499)
        };
        let (from, to) = (towards(corner[0]), towards(corner[2]));
        line.extend((0..=cells).map(|i| {
            let s = i as f32 / cells as f32;
            from.lerp(corner[1], s).lerp(corner[1].lerp(to, s), s)
        }));
    }
    line.extend(points.last().filter(|_| points.len() > 1));
    line
}

/// The number of cells no longer than `cell` that `length` takes, at least one.
fn cells_along(length: f32, cell: f32) -> u32 {
    ((length / cell).ceil() as u32).max(1)
}

/// The point of the unit circle after `turns` turns; exactly the same point after a whole turn, so
/// that what goes around closes.
#[must_use]
pub fn circle(turns: f32) -> Vec2 {
    Vec2::from_angle((turns - turns.floor()) * TAU)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    const STONE: Surface = Surface { material: 0, tile: 1.0 };

    /// The edges that do not belong to exactly one triangle in each direction.
    fn open_edges(mesh: &Mesh) -> usize {
        let mut edges: BTreeMap<[[u32; 3]; 2], i32> = BTreeMap::new();
        for triangle in &mesh.triangles {
            let corners = triangle.corners.map(|c| c.to_array().map(|x| (x + 0.0).to_bits()));
            for i in 0..3 {
                let [from, to] = [corners[i], corners[(i + 1) % 3]];
                *edges.entry([from.min(to), from.max(to)]).or_default() += if from < to { 1 } else { -1 };
            }
        }
        edges.values().filter(|&&sum| sum != 0).count()
    }

    /// Six times the volume that a closed mesh encloses; negative if its fronts face inwards.
    fn volume(mesh: &Mesh) -> f32 {
        mesh.triangles.iter().map(|Triangle { corners: [a, b, c], .. }| a.dot(b.cross(*c))).sum()
    }

    #[test]
    fn solids_are_closed_and_face_outwards() {
        let mut cuboid = Mesh::new(false);
        cuboid.cuboid(STONE, Vec3::splat(1.0), vec3(2.0, 4.0, 3.0), 0.25);
        let mut sphere = Mesh::new(false);
        sphere.sphere(STONE, Vec3::Y, 2.0, 12, 7);
        let mut prism = Mesh::new(false);
        prism.closed_cylinder(STONE, [(Vec3::X, 0.7), (vec3(2.1, 3.3, 1.7), 0.3)], 7, 3);
        let mut vase = Mesh::new(false);
        vase.lathe(STONE, &[vec2(0.0, 0.0), vec2(1.0, 0.5), vec2(0.0, 2.0)], 9);
        let mut cushion = Mesh::new(false);
        cushion.rounded_cuboid(STONE, [Vec3::splat(0.3), vec3(1.1, 2.2, 1.7)], 0.2, 3, [1, 2, 4]);
        for solid in [cuboid, sphere, prism, vase, cushion] {
            assert!(solid.len() > 0);
            assert_eq!(open_edges(&solid), 0);
            assert!(volume(&solid) > 0.0);
        }
    }

    #[test]
    fn rubble_has_exactly_as_many_triangles_as_asked() {
        for count in (0..120).filter(|count| *count == 0 || *count >= 3) {
            let mut mesh = Mesh::new(true);
            let mut slot = 0.0;
            mesh.rubble(STONE, count, &mut Random::new(1), |_| {
                slot += 2.0;
                Affine3A::from_translation(vec3(slot, 0.0, 0.0))
            });
            assert_eq!(mesh.len(), count);
            assert_eq!(mesh.tex_coords.len(), count);
        }
    }

    #[test]
    fn a_rounded_line_keeps_its_ends_and_cuts_its_corner() {
        let line = rounded_line(&[Vec3::ZERO, Vec3::X, vec3(1.0, 1.0, 0.0)], 0.25, 2);
        let expected = [Vec3::ZERO, vec3(0.75, 0.0, 0.0), vec3(0.9375, 0.0625, 0.0), vec3(1.0, 0.25, 0.0)];
        assert_eq!(line[..4], expected);
        assert_eq!(line[4..], [vec3(1.0, 1.0, 0.0)]);
    }

    #[test]
    fn holes_take_their_area_out_of_a_wall() {
        let mut wall = Mesh::new(false);
        let hole = (vec2(1.0, 0.0), vec2(2.0, 2.0));
        wall.pierced_quad(STONE, [Vec3::ZERO, Vec3::X * 4.0, Vec3::Y * 3.0], &[hole], 0.7);
        let area: f32 = wall
            .triangles
            .iter()
            .map(|t| (t.corners[1] - t.corners[0]).cross(t.corners[2] - t.corners[0]).length() / 2.0)
            .sum();
        approx::assert_relative_eq!(area, 4.0 * 3.0 - 1.0 * 2.0, max_relative = 1e-5);
    }

    #[test]
    fn an_untextured_mesh_keeps_no_coordinates() {
        let mut mesh = Mesh::new(false);
        mesh.quad(STONE, Vec3::ZERO, Vec3::X, Vec3::Y, 1.0);
        let (triangles, tex_coords) = mesh.into_parts();
        assert_eq!((triangles.len(), tex_coords.len()), (2, 0));
    }
}
