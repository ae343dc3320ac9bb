//! Vectors of three numbers, and matrices of 4 × 4 by columns.

/// A vector or a point.
pub type Vec3 = [f32; 3];

/// The sum.
pub fn add(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// The difference.
pub fn sub(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// A multiple.
pub fn scale(a: Vec3, by: f32) -> Vec3 {
    a.map(|c| c * by)
}

/// The scalar product.
pub fn dot(a: Vec3, b: Vec3) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The vector product.
pub fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The vector at length 1, or `otherwise` where it has no direction.
pub fn unit_or(a: Vec3, otherwise: Vec3) -> Vec3 {
    let length = dot(a, a).sqrt();
    if length.is_finite() && length > 1e-20 { scale(a, 1.0 / length) } else { otherwise }
}

/// Two unit vectors at right angles to a unit normal and to each other; with it they make a right-handed frame.
pub fn across(normal: Vec3) -> [Vec3; 2] {
    let reference = if normal[1].abs() > 0.9 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let right = unit_or(cross(reference, normal), [1.0, 0.0, 0.0]);
    [right, cross(normal, right)]
}

/// A product of matrices given by columns.
pub fn product(a: [[f32; 4]; 4], b: [[f32; 4]; 4]) -> [[f32; 4]; 4] {
    b.map(|column| {
        std::array::from_fn(|row| {
            a[0][row] * column[0] + a[1][row] * column[1] + a[2][row] * column[2] + a[3][row] * column[3]
        })
    })
}
