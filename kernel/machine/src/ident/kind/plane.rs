//! Actions of codes of tilted planes.

/// How a block says where a plane lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlaneDefinition {
    /// As the data of the form say: 0 Euler, 1 fixed axes, 2 points, 3 directions, 4 projections, 5 turned axes, 6
    /// positions.
    Said,
    /// Angles about Z, the turned X and the turned Z.
    Euler,
    /// Angles about X, Y and Z that stay, in the order of the data, otherwise X, Y, Z.
    Fixed,
    /// Three points.
    Points,
    /// The directions of X and of Z.
    Directions,
    /// Angles of the lines in which the plane cuts two others.
    Projections,
    /// Angles about axes that the ones before have turned, in the order of the data, otherwise X, Y, Z.
    Turned,
    /// Positions of the rotary axes.
    Positions,
}

/// The effect of a code on the tilted plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tilt {
    /// Sets it.
    On(PlaneDefinition),
    /// Sets one in the plane that is active.
    Add(PlaneDefinition),
    /// Ends it.
    Off,
    /// Ends it, or the rotation of the local frame where there is none.
    Cancel,
    /// The rotary axes turn into it.
    Turn,
    /// The same, the tool keeps its place on the part.
    Move,
    /// Of two solutions the one with the tilting axis on the positive side, or on the negative side.
    Side(bool),
    /// A rotary axis that has nothing to do turns the plane.
    Table,
}
