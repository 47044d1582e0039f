//! Pictures: a frame through any memory.

use crate::walk::{PacketSize, TraceOptions};
use crate::world::World;
use anyhow::{Context, Result};
use glam::Vec3;
use image::{ImageFormat, RgbImage};
use saarcor_model::host::Registers;
use saarcor_model::rays::{Frame, Pipeline, RayCounts};
use saarcor_model::vm::{CacheConfig, Counters, Directory, Memory, Observed, VirtualMemory, WholeScene};
use std::io::{Cursor, Write};

/// A picture and the rays that it took.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// The pixels, 8 bits a colour, 255 for 1.0 and above.
    pub pixels: RgbImage,
    /// The rays.
    pub rays: RayCounts,
}

/// The picture of a frame of the world's path, its packets one after the other in scan order.
///
/// # Panics
/// If the path does not have the frame.
#[must_use]
pub fn picture(memory: &mut dyn Memory, world: &World, frame: usize, options: &TraceOptions) -> Picture {
    let (width, height) = options.resolution;
    let frame = Frame::new(&world.path[frame], width, height);
    let mut memory = Observed::by_nobody(memory);
    let (registers, bounces) = (&world.image.registers, options.max_bounces);
    match options.packet {
        PacketSize::Rays1 => packets::<1>(&mut memory, registers, &frame, bounces),
        PacketSize::Rays4 => packets::<4>(&mut memory, registers, &frame, bounces),
        PacketSize::Rays16 => packets::<16>(&mut memory, registers, &frame, bounces),
        PacketSize::Rays64 => packets::<64>(&mut memory, registers, &frame, bounces),
    }
}

/// The picture without virtual memory.
#[must_use]
pub fn through_whole_scene(world: &World, frame: usize, options: &TraceOptions) -> Picture {
    picture(&mut WholeScene(&world.image.bytes), world, frame, options)
}

/// The picture through a virtual memory that is empty at first, and what that did.
#[must_use]
pub fn through_virtual_memory(
    world: &World,
    frame: usize,
    options: &TraceOptions,
    cache: CacheConfig,
) -> (Picture, Counters) {
    match cache.geometry.ways() {
        1 => through_ways::<1>(world, frame, options, cache),
        2 => through_ways::<2>(world, frame, options, cache),
        4 => through_ways::<4>(world, frame, options, cache),
        8 => through_ways::<8>(world, frame, options, cache),
        _ => through_ways::<16>(world, frame, options, cache),
    }
}

fn through_ways<const WAYS: usize>(
    world: &World,
    frame: usize,
    options: &TraceOptions,
    cache: CacheConfig,
) -> (Picture, Counters) {
    let mut memory = VirtualMemory::new(Directory::<WAYS>::new(cache), &world.image.bytes);
    let picture = picture(&mut memory, world, frame, options);
    (picture, memory.directory.counters)
}

fn packets<const N: usize>(
    memory: &mut Observed<&mut dyn Memory>,
    registers: &Registers,
    frame: &Frame,
    max_bounces: u32,
) -> Picture {
    let mut pixels = RgbImage::new(frame.width(), frame.height());
    let mut pipeline = Pipeline::<N>::new(max_bounces);
    for packet in 0..frame.packets::<N>() {
        let colours = pipeline.render(memory, registers, frame, packet);
        put_packet(&mut pixels, frame, packet, &colours);
    }
    Picture { pixels, rays: pipeline.rays }
}

/// Puts the colours of a packet's rays where they belong.
pub(crate) fn put_packet<const N: usize>(
    pixels: &mut RgbImage,
    frame: &Frame,
    packet: u32,
    colours: &[Vec3; N],
) {
    for (pixel, colour) in frame.pixels::<N>(packet).into_iter().zip(colours) {
        if let Some((x, y)) = pixel {
            pixels.put_pixel(x, y, image::Rgb(eight_bits(*colour)));
        }
    }
}

/// A colour of 0 to 1, rounded to 0 to 255.
fn eight_bits(colour: Vec3) -> [u8; 3] {
    // The cast takes what lies outside to the nearest end.
    colour.to_array().map(|part| (part * 255.0).round() as u8)
}

impl Picture {
    /// Writes the picture as PNG.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write_png(&self, out: &mut dyn Write) -> Result<()> {
        let mut png = Cursor::new(Vec::new());
        self.pixels.write_to(&mut png, ImageFormat::Png).context("picture as PNG")?;
        Ok(out.write_all(png.get_ref())?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_clamped_and_rounded() {
        assert_eq!(eight_bits(Vec3::new(-1.0, 0.5, 7.0)), [0, 128, 255]);
    }
}
