//! Views of scenes, meshes and solids.

mod mesh;
mod silhouettes;
mod solid;
mod spaces;
