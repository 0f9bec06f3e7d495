// Nearest-neighbour tracker in its own process; also writes its tracks as CSV.
//   g++ -O2 -o nearest docs/examples/process/nearest.cpp
//   luxloop run docs/examples/my-first.toml --tracker "process:./nearest tracks.csv"
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

struct Car { int64_t id; double x, y; };
struct Cluster { float x0, x1, y0, y1; int points; };

template <class T> std::vector<T> read_column(size_t count) {
    std::vector<T> column(count);
    if (std::fread(column.data(), sizeof(T), count, stdin) != count) std::exit(1);
    return column;
}
template <class T> void write_column(const std::vector<T>& column) {
    std::fwrite(column.data(), sizeof(T), column.size(), stdout);
}

double middle(double low, double high, double size) {  // of a car whose far side is hidden
    return (low + high + std::copysign(std::fmax(size - (high - low), 0), low + high)) / 2;
}

int main(int, char** arguments) {
    FILE* csv = std::fopen(arguments[1], "w");
    std::fprintf(csv, "frame,track_id,x_odom_m,y_odom_m,heading_odom_rad,length_m,width_m\n");
    std::vector<Car> last;
    int64_t born = 0;
    write_column(read_column<char>(8)), std::fflush(stdout);  // the greeting, LUXLOOP1
    for (uint32_t length; std::fread(&length, 4, 1, stdin) == 1;) {
        const auto head = read_column<uint32_t>(2);  // frame, points
        const auto pose = read_column<double>(4);    // time, x, y, yaw
        const auto x = read_column<float>(head[1]), y = read_column<float>(head[1]), z = read_column<float>(head[1]);
        read_column<char>(13 * head[1]);  // the other columns of the points
        std::vector<Cluster> clusters;
        for (size_t i = 0; i < x.size(); ++i) {
            if (!(z[i] > 0.3f) || !(std::hypot(x[i], y[i]) < 50.0f)) continue;
            auto c = std::find_if(clusters.begin(), clusters.end(), [&](const Cluster& c) {
                return x[i] > c.x0 - 1 && x[i] < c.x1 + 1 && y[i] > c.y0 - 1 && y[i] < c.y1 + 1; });
            if (c == clusters.end()) c = clusters.insert(c, {x[i], x[i], y[i], y[i], 0});
            *c = {std::min(c->x0, x[i]), std::max(c->x1, x[i]), std::min(c->y0, y[i]), std::max(c->y1, y[i]), c->points + 1};
        }
        std::vector<int64_t> ids;
        std::vector<double> xs, ys;
        std::vector<Car> cars;
        for (const Cluster& c : clusters) {
            if (c.points < 10 || c.x1 - c.x0 > 7 || c.y1 - c.y0 > 7) continue;
            const double u = middle(c.x0, c.x1, 4.5), v = middle(c.y0, c.y1, 1.8);
            const double cosine = std::cos(pose[3]), sine = std::sin(pose[3]);
            Car car{0, pose[1] + cosine * u - sine * v, pose[2] + sine * u + cosine * v};
            const auto away = [&](const Car& old) { return std::hypot(old.x - car.x, old.y - car.y); };
            auto old = std::min_element(last.begin(), last.end(), [&](auto& a, auto& b) { return away(a) < away(b); });
            const bool known = old != last.end() && away(*old) < 2;
            car.id = known ? old->id : ++born;
            if (known) last.erase(old);
            cars.push_back(car), ids.push_back(car.id), xs.push_back(car.x), ys.push_back(car.y);
            std::fprintf(csv, "%u,%ld,%.17g,%.17g,%.17g,4.5,1.8\n", head[0], long(car.id), car.x, car.y, pose[3]);
        }
        const uint32_t count = cars.size();
        write_column<uint32_t>({8 + 65 * count, head[0], count}), write_column(ids), write_column(xs), write_column(ys);
        for (double value : {pose[3], 4.5, 1.8, double(NAN), double(NAN)})  // heading, size, unknown velocity
            write_column(std::vector<double>(count, value));
        write_column(std::vector<uint8_t>(count, 1)), std::fflush(stdout);  // status 1: confirmed
        last = cars;
    }
    return std::fclose(csv);
}
