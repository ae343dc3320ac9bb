//! The Fourier transform of small grids, in plain arithmetic: libraries choose instructions at run time, and with them roundings.

use rayon::prelude::*;

/// A complex number.
pub(super) type Complex = [f64; 2];

/// Transforms a grid in place, x fastest; edges are powers of two. The inverse is not divided by the number of places.
pub(super) fn transform(grid: &mut [Complex], size: [usize; 3], inverse: bool) {
    let [nx, ny, nz] = size;
    let twiddles = [nx, ny, nz].map(|n| twiddles(n, inverse));
    grid.par_chunks_mut(nx * ny).for_each(|layer| {
        layer.chunks_mut(nx).for_each(|line| fft(line, &twiddles[0]));
        let mut line = vec![[0.0; 2]; ny];
        for x in 0..nx {
            (0..ny).for_each(|y| line[y] = layer[y * nx + x]);
            fft(&mut line, &twiddles[1]);
            (0..ny).for_each(|y| layer[y * nx + x] = line[y]);
        }
    });
    // Lines along z cross the layers: columns of them are gathered, transformed, and written back.
    let columns: Vec<Vec<Complex>> = (0..ny)
        .into_par_iter()
        .map(|y| {
            let mut lines = vec![[0.0; 2]; nx * nz];
            for z in 0..nz {
                for x in 0..nx {
                    lines[x * nz + z] = grid[(z * ny + y) * nx + x];
                }
            }
            lines.chunks_mut(nz).for_each(|line| fft(line, &twiddles[2]));
            lines
        })
        .collect();
    grid.par_chunks_mut(nx * ny).enumerate().for_each(|(z, layer)| {
        for (y, lines) in columns.iter().enumerate() {
            for x in 0..nx {
                layer[y * nx + x] = lines[x * nz + z];
            }
        }
    });
}

/// The product of two complex numbers.
pub(super) fn times(a: Complex, b: Complex) -> Complex {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

fn twiddles(n: usize, inverse: bool) -> Vec<Complex> {
    let sign = if inverse { 1.0 } else { -1.0 };
    (0..n / 2)
        .map(|k| {
            let angle = sign * std::f64::consts::TAU * k as f64 / n as f64;
            [libm::cos(angle), libm::sin(angle)]
        })
        .collect()
}

/// Cooley & Tukey 1965, radix 2.
fn fft(line: &mut [Complex], twiddles: &[Complex]) {
    let n = line.len();
    if n < 2 {
        return;
    }
    let bits = n.trailing_zeros();
    for i in 0..n {
        let j = i.reverse_bits() >> (usize::BITS - bits);
        if i < j {
            line.swap(i, j);
        }
    }
    let mut half = 1;
    while half < n {
        let step = n / (2 * half);
        for start in (0..n).step_by(2 * half) {
            for k in 0..half {
                let (a, b) = (line[start + k], times(line[start + k + half], twiddles[k * step]));
                line[start + k] = [a[0] + b[0], a[1] + b[1]];
                line[start + k + half] = [a[0] - b[0], a[1] - b[1]];
            }
        }
        half *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_convolution_equals_its_sum() {
        let size = [8usize, 4, 16];
        let count = size.iter().product::<usize>();
        let value = |i: usize, k: usize| ((i * 7919 + k * 104_729) % 97) as f64 / 97.0;
        let (a, b): (Vec<f64>, Vec<f64>) = (0..count).map(|i| (value(i, 1), value(i, 2))).unzip();
        let spectrum = |v: &[f64]| {
            let mut grid: Vec<Complex> = v.iter().map(|&v| [v, 0.0]).collect();
            transform(&mut grid, size, false);
            grid
        };
        let mut product: Vec<Complex> =
            spectrum(&a).into_iter().zip(spectrum(&b)).map(|(a, b)| times(a, b)).collect();
        transform(&mut product, size, true);
        let place = |i: usize| [i % size[0], i / size[0] % size[1], i / size[0] / size[1]];
        for i in (0..count).step_by(11) {
            let sum: f64 = (0..count)
                .map(|j| {
                    let (p, q) = (place(i), place(j));
                    let d: [usize; 3] = std::array::from_fn(|c| (p[c] + size[c] - q[c]) % size[c]);
                    a[j] * b[(d[2] * size[1] + d[1]) * size[0] + d[0]]
                })
                .sum();
            assert!((product[i][0] / count as f64 - sum).abs() < 1e-9 && product[i][1].abs() < 1e-6);
        }
    }
}
