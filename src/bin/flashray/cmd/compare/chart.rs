//! Bar plots as SVG.
use super::page::escaped;
use crate::kinds::KINDS;
use std::fmt::Write as _;

/// A plot: for each row a bar for each series, or one bar of them all.
pub struct Chart<'a> {
    pub title: &'a str,
    /// What the axis counts.
    pub unit: &'a str,
    pub series: &'a [&'a str],
    pub rows: Vec<(String, Vec<Option<f64>>)>,
    /// Series lie end to end in one bar.
    pub stacked: bool,
    pub decimals: usize,
}

const WIDTH: f64 = 760.0;
const LEFT: f64 = 110.0;
const RIGHT: f64 = 80.0;
const TOP: f64 = 58.0;
const GAP: f64 = 9.0;
/// Below the bars, for the axis.
const BOTTOM: f64 = 40.0;
/// How thick the bars of a group are, and one alone.
const THIN: f64 = 11.0;
const THICK: f64 = 15.0;

impl Chart<'_> {
    /// The picture; its colours are the page's classes `c0`, `c1` and so on.
    pub fn svg(&self) -> String {
        let bars = if self.stacked { 1 } else { self.series.len() };
        let thick = if bars == 1 { THICK } else { THIN };
        let row_height = thick * bars as f64 + GAP;
        let height = TOP + row_height * self.rows.len() as f64 + BOTTOM;
        let total = |values: &[Option<f64>]| values.iter().flatten().sum::<f64>();
        let largest = |values: &[Option<f64>]| values.iter().flatten().fold(0.0f64, |a, &b| a.max(b));
        let of = |values: &[Option<f64>]| if self.stacked { total(values) } else { largest(values) };
        let most = self.rows.iter().map(|(_, values)| of(values)).fold(0.0, f64::max);
        // Where all is 0, as when no ray meets the scene, the axis goes to 1.
        let most = if most > 0.0 { most } else { 1.0 };
        let scale = (WIDTH - LEFT - RIGHT) / most;
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"chart\" viewBox=\"0 0 {WIDTH} {height}\" role=\"img\">\
             <title>{0}</title><text class=\"h\" x=\"0\" y=\"18\">{0}</text>\n",
            escaped(self.title)
        );
        for (i, name) in self.series.iter().enumerate() {
            let x = LEFT + 150.0 * i as f64;
            // Writing to a string does not fail, here and below.
            let _ = writeln!(
                svg,
                "<rect class=\"c{}\" x=\"{x}\" y=\"32\" width=\"11\" height=\"11\"/><text x=\"{}\" y=\"42\">{name}</text>",
                self.color(i),
                x + 16.0
            );
        }
        svg += &self.axis(most, scale, height - BOTTOM);
        for (i, (label, values)) in self.rows.iter().enumerate() {
            let y = TOP + row_height * i as f64;
            let middle = y + (row_height - GAP) / 2.0 + 4.0;
            let _ = writeln!(svg, "<text class=\"l\" x=\"{}\" y=\"{middle:.1}\">{}</text>", LEFT - 8.0, escaped(label));
            svg += &if self.stacked { self.stack(values, y, scale) } else { self.group(values, y, scale) };
        }
        svg + "</svg>\n"
    }

    /// Lines at round numbers, the numbers, and their unit.
    fn axis(&self, most: f64, scale: f64, y: f64) -> String {
        let step = [1.0, 2.0, 5.0, 10.0].map(|x| x * 10f64.powf((most / 8.0).log10().floor()));
        let step = step.into_iter().find(|step| most / step <= 8.0).unwrap_or(most);
        let decimals = (-step.log10().floor()).max(0.0) as usize;
        let mut svg = String::new();
        for i in 0..=(most / step) as u32 {
            let value = f64::from(i) * step;
            let x = LEFT + value * scale;
            let _ = writeln!(
                svg,
                "<path class=\"a\" d=\"M{x:.1} {}V{y:.1}\"/><text class=\"t\" x=\"{x:.1}\" y=\"{:.1}\">{value:.decimals$}</text>",
                TOP - 6.0,
                y + 13.0
            );
        }
        let middle = f64::midpoint(LEFT, WIDTH - RIGHT);
        svg + &format!("<text class=\"t\" x=\"{middle}\" y=\"{:.1}\">{}</text>\n", y + 31.0, escaped(self.unit))
    }

    /// A kind of rays has one colour in all plots.
    fn color(&self, series: usize) -> usize {
        KINDS.iter().position(|kind| *kind == self.series[series]).unwrap_or(series)
    }

    fn group(&self, values: &[Option<f64>], y: f64, scale: f64) -> String {
        let bar = |(i, value): (usize, &Option<f64>)| {
            let y = y + THIN * i as f64;
            match value {
                Some(value) => {
                    format!(
                        "{}{}",
                        bar(self.color(i), LEFT, y, value * scale, THIN - 1.0),
                        self.number(*value, y + 9.0, scale)
                    )
                }
                None => String::new(),
            }
        };
        values.iter().enumerate().map(bar).collect()
    }

    fn stack(&self, values: &[Option<f64>], y: f64, scale: f64) -> String {
        let (mut svg, mut sum) = (String::new(), 0.0);
        for (i, value) in values.iter().enumerate() {
            let value = value.unwrap_or(0.0);
            svg += &bar(self.color(i), LEFT + sum * scale, y, value * scale, THICK);
            sum += value;
        }
        svg + &self.number(sum, y + 12.0, scale)
    }

    fn number(&self, value: f64, y: f64, scale: f64) -> String {
        // The list's speed has its first digit far behind the point.
        let decimals = if value < 0.1 { 4 } else { self.decimals };
        let x = LEFT + value * scale + 5.0;
        format!("<text class=\"v\" x=\"{x:.1}\" y=\"{y:.1}\">{value:.decimals$}</text>\n")
    }
}

fn bar(series: usize, x: f64, y: f64, width: f64, height: f64) -> String {
    format!("<rect class=\"c{series}\" x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height}\"/>")
}
