//! What the insides of the built-in buildings are made of.

use glam::vec3;
use saarcor_model::host::{Material, Triangle};

use super::mesh::Surface;
use super::palette::{glossy, matt, mirror};

/// A named material.
///
/// The colours are Assumed: the paper shows its interiors and lists none of their materials.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
#[allow(missing_docs)] // The names say it.
pub enum Finish {
    Plaster,
    Plasterboard,
    CeilingTile,
    Carpet,
    CarpetBorder,
    Linoleum,
    Concrete,
    Wood,
    DarkWood,
    Steel,
    Brass,
    PlasticBlack,
    PlasticGrey,
    PlasticBeige,
    FabricBlue,
    FabricRed,
    FabricGrey,
    Curtain,
    Slat,
    Lamp,
    Paper,
    Whiteboard,
    Screen,
    Leaf,
    Soil,
    Terracotta,
    SignalRed,
    Porcelain,
    BookRed,
    BookGreen,
    BookBlue,
    BookOchre,
    PolishedWood,
    Mirror,
    Pane,
}

impl Finish {
    /// Every finish, in the order of the numbers.
    const ALL: [Self; 35] = [
        Self::Plaster,
        Self::Plasterboard,
        Self::CeilingTile,
        Self::Carpet,
        Self::CarpetBorder,
        Self::Linoleum,
        Self::Concrete,
        Self::Wood,
        Self::DarkWood,
        Self::Steel,
        Self::Brass,
        Self::PlasticBlack,
        Self::PlasticGrey,
        Self::PlasticBeige,
        Self::FabricBlue,
        Self::FabricRed,
        Self::FabricGrey,
        Self::Curtain,
        Self::Slat,
        Self::Lamp,
        Self::Paper,
        Self::Whiteboard,
        Self::Screen,
        Self::Leaf,
        Self::Soil,
        Self::Terracotta,
        Self::SignalRed,
        Self::Porcelain,
        Self::BookRed,
        Self::BookGreen,
        Self::BookBlue,
        Self::BookOchre,
        Self::PolishedWood,
        Self::Mirror,
        Self::Pane,
    ];

    /// The colours of book covers.
    pub const BOOKS: [Self; 6] = [
        Self::BookRed,
        Self::BookGreen,
        Self::BookBlue,
        Self::BookOchre,
        Self::PlasticBlack,
        Self::PlasticBeige,
    ];

    /// The materials that the triangles use. Their indices, up to here the finishes' own numbers,
    /// are set to match.
    #[must_use]
    pub fn materials(triangles: &mut [Triangle]) -> Vec<Material> {
        let mut used = [false; Self::ALL.len()];
        for triangle in triangles.iter() {
            used[triangle.material as usize] = true;
        }
        let (mut materials, mut index) = (Vec::new(), [0; Self::ALL.len()]);
        for finish in Self::ALL.into_iter().filter(|&finish| used[finish as usize]) {
            index[finish as usize] = materials.len() as u32;
            materials.push(finish.material());
        }
        for triangle in triangles {
            triangle.material = index[triangle.material as usize];
        }
        materials
    }

    /// The surface of this finish, untextured.
    #[must_use]
    pub fn surface(self) -> Surface {
        Surface { material: self as u32, tile: 1.0 }
    }

    fn material(self) -> Material {
        match self {
            Self::Plaster => matt(vec3(0.72, 0.70, 0.64)),
            Self::Plasterboard => matt(vec3(0.66, 0.68, 0.66)),
            Self::CeilingTile => matt(vec3(0.78, 0.78, 0.76)),
            Self::Carpet => matt(vec3(0.30, 0.34, 0.42)),
            Self::CarpetBorder => matt(vec3(0.42, 0.20, 0.20)),
            Self::Linoleum => matt(vec3(0.52, 0.48, 0.40)),
            Self::Concrete => matt(vec3(0.55, 0.54, 0.52)),
            Self::Wood => matt(vec3(0.60, 0.40, 0.24)),
            Self::DarkWood => matt(vec3(0.38, 0.23, 0.20)),
            Self::Steel => glossy(vec3(0.48, 0.50, 0.52)),
            Self::Brass => glossy(vec3(0.60, 0.48, 0.22)),
            Self::PlasticBlack => glossy(vec3(0.20, 0.20, 0.21)),
            Self::PlasticGrey => glossy(vec3(0.40, 0.41, 0.43)),
            Self::PlasticBeige => glossy(vec3(0.66, 0.62, 0.52)),
            Self::FabricBlue => matt(vec3(0.22, 0.28, 0.50)),
            Self::FabricRed => matt(vec3(0.52, 0.20, 0.22)),
            Self::FabricGrey => matt(vec3(0.36, 0.36, 0.38)),
            Self::Curtain => matt(vec3(0.56, 0.38, 0.30)),
            Self::Slat => matt(vec3(0.74, 0.72, 0.66)),
            Self::Lamp => matt(vec3(0.80, 0.80, 0.76)),
            Self::Paper => matt(vec3(0.78, 0.78, 0.75)),
            Self::Whiteboard => glossy(vec3(0.78, 0.79, 0.80)),
            Self::Screen => glossy(vec3(0.20, 0.26, 0.30)),
            Self::Leaf => matt(vec3(0.20, 0.44, 0.20)),
            Self::Soil => matt(vec3(0.30, 0.24, 0.20)),
            Self::Terracotta => matt(vec3(0.62, 0.34, 0.24)),
            Self::SignalRed => glossy(vec3(0.70, 0.20, 0.20)),
            Self::Porcelain => glossy(vec3(0.76, 0.76, 0.74)),
            Self::BookRed => matt(vec3(0.55, 0.20, 0.20)),
            Self::BookGreen => matt(vec3(0.20, 0.40, 0.30)),
            Self::BookBlue => matt(vec3(0.20, 0.30, 0.52)),
            Self::BookOchre => matt(vec3(0.66, 0.52, 0.26)),
            Self::PolishedWood => glossy(vec3(0.42, 0.26, 0.20)),
            Self::Mirror => mirror(vec3(0.30, 0.30, 0.32), 0.5),
            Self::Pane => glossy(vec3(0.20, 0.24, 0.30)),
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn a_finish_is_numbered_by_its_place_among_the_materials() {
        for (i, finish) in Finish::ALL.iter().enumerate() {
            assert_eq!(*finish as usize, i);
        }
    }

    #[test]
    fn only_the_materials_in_use_remain() {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let mut triangles = [Finish::Mirror, Finish::Carpet, Finish::Mirror]
            .map(|finish| Triangle { corners, material: finish.surface().material });
        let materials = Finish::materials(&mut triangles);
        assert_eq!(materials, [Finish::Carpet.material(), Finish::Mirror.material()]);
        assert_eq!(triangles.map(|triangle| triangle.material), [1, 0, 1]);
    }
}
