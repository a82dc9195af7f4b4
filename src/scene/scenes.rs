//! The table of scenes: what is in each, and where it is best seen from.

use super::camera::Camera;
use super::cuboid::Cuboid;
use super::error::SceneError;
use super::lathe::Lathe;
use super::plane::{Plane, PlaneKind};
use super::ray::Surface;
use super::sphere::Sphere;
use super::spline::polyline;
use super::torus::Torus;
use super::vase::vase;
use glam::DVec3;

/// The description of a scene.
#[derive(Debug)]
pub struct SceneInfo {
    /// The name for [`super::render`].
    pub name: &'static str,
    /// A description, in one line.
    pub brief: &'static str,
    /// The names of the surfaces, from number 1; each is a noun.
    pub surfaces: &'static [&'static str],
    /// The default eye, in unscaled world units.
    pub eye: [f64; 3],
    /// The default point at the centre of the picture, in unscaled world units.
    pub look_at: [f64; 3],
    /// The minimum width and height of the view, in unscaled world units at the distance of `look_at`.
    pub frame: [f64; 2],
    /// Whether it has the variables of the far side: `exit_point`, `exit_normal`, `exit_uv`.
    pub exits: bool,
    build: fn(&Camera) -> Result<World, SceneError>,
}

/// The surfaces of a scene; the index is the number of `surface` less 1.
pub(super) type World = Vec<Box<dyn Surface>>;

impl SceneInfo {
    /// The scene's surfaces; some face the camera.
    pub(super) fn build(&self, camera: &Camera) -> Result<World, SceneError> {
        (self.build)(camera)
    }
}

/// All scenes.
pub fn scenes() -> &'static [SceneInfo] {
    SCENES
}

/// Finds the scene with this name; the error has the closest name.
pub fn find(name: &str) -> Result<&'static SceneInfo, SceneError> {
    SCENES.iter().find(|s| s.name == name).ok_or_else(|| SceneError::UnknownScene {
        name: name.into(),
        nearest: crate::spelling::nearest(name, SCENES.iter().map(|s| s.name)),
        names: SCENES.iter().map(|s| s.name).collect(),
    })
}

const UNIT_SPHERE: Sphere = Sphere { center: DVec3::ZERO, radius: 1.0 };

const SCENES: &[SceneInfo] = &[
    SceneInfo {
        name: "donut",
        brief: "the paper's donut: a torus of radii 1 and 0.5, seen from above its front",
        surfaces: &["donut"],
        eye: [0.0, -4.5, 4.9],
        look_at: [0.0, -0.1, -0.1],
        frame: [3.4, 2.9],
        exits: false,
        build: |_| Ok(vec![Box::new(Torus { center: DVec3::ZERO, major: 1.0, minor: 0.5 })]),
    },
    SceneInfo {
        name: "vase",
        brief: "an open vase, 10 high and 6.6 wide, standing on the origin",
        surfaces: &["vase"],
        eye: [0.0, -27.0, 15.0],
        look_at: [0.0, 0.0, 4.9],
        frame: [7.4, 11.6],
        exits: false,
        build: |_| Ok(vec![Box::new(vase())]),
    },
    SceneInfo {
        name: "sphere",
        brief: "a sphere of radius 1 around the origin",
        surfaces: &["sphere"],
        eye: [0.0, -6.0, 0.0],
        look_at: [0.0; 3],
        frame: [2.3, 2.3],
        exits: false,
        build: |_| Ok(vec![Box::new(UNIT_SPHERE)]),
    },
    SceneInfo {
        name: "bubble",
        brief: "a sphere of radius 1 to see through: exit_point, exit_normal and exit_uv are of its far side",
        surfaces: &["bubble"],
        eye: [0.0, -6.0, 0.0],
        look_at: [0.0; 3],
        frame: [2.5, 2.5],
        exits: true,
        build: |_| Ok(vec![Box::new(UNIT_SPHERE)]),
    },
    SceneInfo {
        name: "star",
        brief: "a sphere of radius 1 (surface 1) and, around it, a card through its centre (surface 2)",
        surfaces: &["star", "card"],
        eye: [0.0, -12.0, 0.0],
        look_at: [0.0; 3],
        frame: [4.4, 4.4],
        exits: false,
        build: |camera| Ok(vec![Box::new(UNIT_SPHERE), Box::new(card(camera)?)]),
    },
    SceneInfo {
        name: "card",
        brief: "a plane through the origin that faces the eye and fills the picture",
        surfaces: &["card"],
        eye: [0.0, -12.0, 0.0],
        look_at: [0.0; 3],
        frame: [4.4, 4.4],
        exits: false,
        build: |camera| Ok(vec![Box::new(card(camera)?)]),
    },
    SceneInfo {
        name: "ocean",
        brief: "water at z = 0 out to the horizon, under a sky (surface 0, to be painted by I)",
        surfaces: &["water"],
        eye: [0.0, -10.0, 1.6],
        look_at: [0.0, 0.0, 1.3],
        frame: [8.0, 6.0],
        exits: false,
        build: |_| Ok(vec![Box::new(Plane::horizontal(0.0, PlaneKind::Ground))]),
    },
    SceneInfo {
        name: "window",
        brief: "a pane, 3 wide and 2 high, upright at y = 0, seen a little from the side",
        surfaces: &["window"],
        eye: [-1.1, -5.6, 0.45],
        look_at: [-0.06, 0.0, 0.0],
        frame: [3.3, 2.4],
        exits: false,
        build: |_| {
            let (du, dv) = (DVec3::X * 3.0, DVec3::Z * 2.0);
            Ok(vec![Box::new(Plane { origin: -0.5 * (du + dv), du, dv, kind: PlaneKind::Pane })])
        },
    },
    SceneInfo {
        name: "plane",
        brief: "an endless floor at z = 0 that recedes to the horizon",
        surfaces: &["plane"],
        eye: [0.0, -5.0, 2.0],
        look_at: [0.0, 0.0, 0.6],
        frame: [5.6, 4.2],
        exits: false,
        build: |_| Ok(vec![Box::new(Plane::horizontal(0.0, PlaneKind::Endless))]),
    },
    SceneInfo {
        name: "floor",
        brief: "a sphere, a donut, a cylinder and a cube on an endless floor whose u is x and v is y",
        surfaces: &["floor", "sphere", "donut", "cylinder", "cube"],
        eye: [1.4, -8.6, 4.2],
        look_at: [0.0, 0.25, 0.6],
        frame: [6.4, 4.4],
        exits: false,
        build: |_| {
            let cylinder = polyline(&[[0.0, 0.0], [0.55, 0.0], [0.55, 1.9], [0.0, 1.9]]);
            Ok(vec![
                Box::new(Plane::horizontal(0.0, PlaneKind::Endless)),
                Box::new(Sphere { center: DVec3::new(-1.55, 0.1, 0.8), radius: 0.8 }),
                Box::new(Torus { center: DVec3::new(0.35, -1.35, 0.3), major: 0.7, minor: 0.3 }),
                Box::new(Lathe::new(DVec3::new(0.2, 1.3, 0.0), &cylinder, 3)),
                Box::new(Cuboid::standing(DVec3::new(2.05, 0.35, 0.0), 1.25, 0.8, 0.6)),
            ])
        },
    },
];

/// The plane through the origin across the view axis; u goes to the right of the picture and v up, in world units.
fn card(camera: &Camera) -> Result<Plane, SceneError> {
    if (-camera.eye).dot(camera.forward) <= 1e-9 * camera.eye.length().max(1.0) {
        return Err(SceneError::OriginBehind);
    }
    Ok(Plane { origin: DVec3::ZERO, du: camera.right, dv: camera.up, kind: PlaneKind::Endless })
}
