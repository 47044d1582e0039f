//! Ray generation: primary rays of a camera in packets of square tiles, and the rays that start
//! where another ray hit (§2).

use super::ray::{Packet, Ray};
use crate::host::Camera;
use glam::Vec3;

/// Part of the size of the coordinates by which a new ray starts off the surface, so that it does
/// not hit the surface that it comes from (RG-3, Assumed: 64 times the spacing of f32 there).
pub const SURFACE_OFFSET: f32 = 64.0 * f32::EPSILON;

/// One picture to be made: a camera with the picture's size in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    eye: Vec3,
    dir: Vec3,
    /// From the picture's centre to its right edge at distance 1.
    right: Vec3,
    /// From the picture's centre to its top edge at distance 1.
    up: Vec3,
    width: u32,
    height: u32,
}

impl Frame {
    /// The picture of `width × height` square pixels that `camera` takes.
    pub fn new(camera: &Camera, width: u32, height: u32) -> Self {
        let half_height = libm::tanf(camera.fov_y_deg.to_radians() / 2.0);
        let half_width = half_height * width as f32 / height as f32;
        Self {
            eye: camera.eye,
            dir: camera.dir,
            right: camera.dir.cross(camera.up) * half_width,
            up: camera.up * half_height,
            width,
            height,
        }
    }

    /// Pixels a row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows of pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Width of a pixel at distance 1, in the picture's middle.
    pub fn pixel_width(&self) -> f32 {
        2.0 * self.up.length() / self.height as f32
    }

    /// The ray through the centre of a pixel; rows count from the top (RG-1).
    pub fn primary_ray(&self, x: u32, y: u32) -> Ray {
        let along = (2.0 * x as f32 + 1.0) / self.width as f32 - 1.0;
        let upwards = 1.0 - (2.0 * y as f32 + 1.0) / self.height as f32;
        let direction = (self.dir + self.right * along + self.up * upwards).normalize();
        Ray { origin: self.eye, direction, t_min: 0.0, t_max: f32::INFINITY }
    }

    /// Tiles a row and rows of tiles, for packets of `N` rays.
    pub fn tiles<const N: usize>(&self) -> (u32, u32) {
        let side = tile_side(N);
        (self.width.div_ceil(side), self.height.div_ceil(side))
    }

    /// Number of packets of `N` rays that make the picture.
    pub fn packets<const N: usize>(&self) -> u32 {
        let (columns, rows) = self.tiles::<N>();
        columns * rows
    }

    /// The pixel of each lane of a packet, by rows within the tile; none beyond the picture's
    /// edge. Packets count in scan order: tiles from left to right, then downwards (RG-2).
    pub fn pixels<const N: usize>(&self, packet: u32) -> [Option<(u32, u32)>; N] {
        let side = tile_side(N);
        let (columns, _) = self.tiles::<N>();
        let (left, top) = (packet % columns * side, packet / columns * side);
        std::array::from_fn(|lane| {
            let (x, y) = (left + lane as u32 % side, top + lane as u32 / side);
            (x < self.width && y < self.height).then_some((x, y))
        })
    }

    /// The primary rays of a packet.
    pub fn primary_packet<const N: usize>(&self, packet: u32) -> Packet<N> {
        Packet::new(self.pixels(packet).map(|pixel| pixel.map(|(x, y)| self.primary_ray(x, y))))
    }
}

/// Pixels along a side of the square tile of a packet of `N` rays.
///
/// # Panics
/// If `N` is no square number.
fn tile_side(n: usize) -> u32 {
    let side = n.isqrt();
    assert!(side * side == n, "a packet's rays fill a square tile");
    side as u32
}

/// A ray from `point` of a surface along `direction`, up to distance `t_max` (RG-3).
///
/// `scale` is the largest coordinate that the point was computed from: its error is a multiple of
/// the spacing of f32 there. The ray starts off the surface, on the side of the plane with unit
/// normal `normal` to which it goes.
pub fn ray_from_surface(point: Vec3, scale: f32, normal: Vec3, direction: Vec3, t_max: f32) -> Ray {
    let side = if direction.dot(normal) < 0.0 { -normal } else { normal };
    Ray { origin: point + side * (SURFACE_OFFSET * scale), direction, t_min: 0.0, t_max }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(width: u32, height: u32) -> Frame {
        let camera = Camera { eye: Vec3::ZERO, dir: Vec3::NEG_Z, up: Vec3::Y, fov_y_deg: 90.0 };
        Frame::new(&camera, width, height)
    }

    #[test]
    fn picture_is_upright_and_not_mirrored() {
        let frame = frame(40, 30);
        let (top_left, bottom_right) = (frame.primary_ray(0, 0), frame.primary_ray(39, 29));
        assert!(top_left.direction.x < 0.0 && top_left.direction.y > 0.0);
        assert!(bottom_right.direction.x > 0.0 && bottom_right.direction.y < 0.0);
        assert!(top_left.direction.z < 0.0);
    }

    #[test]
    fn packets_cover_each_pixel_once() {
        let frame = frame(21, 10);
        let mut seen = vec![0; 210];
        for packet in 0..frame.packets::<64>() {
            for (x, y) in frame.pixels::<64>(packet).into_iter().flatten() {
                seen[(y * 21 + x) as usize] += 1;
            }
        }
        assert!(seen.iter().all(|&times| times == 1));
        assert_eq!(frame.packets::<1>(), 210);
    }
}
