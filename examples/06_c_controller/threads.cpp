// Compensation in a controller, in C++: one fit, shared by four threads, each with an arm of its own.
//
//   threads FIT.json

#include "truepose.h"
#include <cmath>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

struct FreeFit {
    void operator()(truepose_fit *fit) const { truepose_fit_free(fit); }
};
struct FreeArm {
    void operator()(truepose_arm *arm) const { truepose_arm_free(arm); }
};

static void check(int32_t code) {
    if (code < 0) throw std::runtime_error(std::string(truepose_message(code)) + ": " + truepose_last_error());
}

class Fit {
public:
    explicit Fit(const char *path) {
        truepose_fit *read = nullptr;
        check(truepose_fit_read(path, &read));
        fit.reset(read);
    }
    const truepose_fit *get() const { return fit.get(); }

private:
    std::unique_ptr<truepose_fit, FreeFit> fit;
};

class Arm {
public:
    explicit Arm(const Fit &fit) : joints(truepose_fit_joints(fit.get())) {
        truepose_options options;
        check(truepose_options_default(&options));
        options.position_tolerance = 1e-7;
        options.orientation_tolerance = 1e-7;
        truepose_arm *made = nullptr;
        check(truepose_arm_new(fit.get(), &options, &made));
        arm.reset(made);
    }

    truepose_pose predict(const std::vector<double> &q) {
        truepose_pose pose;
        check(truepose_predict(arm.get(), q.data(), q.size(), nullptr, TRUEPOSE_TOOL, &pose));
        return pose;
    }

    /// False where the pose cannot be reached: `q` is then as it was.
    bool command(const truepose_pose &pose, std::vector<double> &q) {
        truepose_target desired{};
        for (int k = 0; k < 3; k++) desired.position[k] = pose.position[k];
        for (int k = 0; k < 4; k++) desired.quaternion[k] = pose.quaternion[k];
        desired.has_orientation = 1;
        desired.target = TRUEPOSE_TOOL;
        int32_t code = truepose_command(arm.get(), &desired, nullptr, q.data(), q.data(), q.size(), nullptr);
        check(code);
        return code == TRUEPOSE_OK;
    }

    const std::size_t joints;

private:
    std::unique_ptr<truepose_arm, FreeArm> arm;
};

int main(int count, char **words) {
    if (count < 2) return 2;
    try {
        auto fit = std::make_unique<Fit>(words[1]);
        std::vector<std::vector<double>> results(4);
        std::vector<int> failures(4, 0);
        std::vector<std::thread> threads;
        std::vector<std::unique_ptr<Arm>> arms;
        for (int t = 0; t < 4; t++) arms.push_back(std::make_unique<Arm>(*fit));
        fit.reset(); // An arm keeps what it needs.
        for (int t = 0; t < 4; t++)
            threads.emplace_back([&, t] {
                Arm &arm = *arms[t];
                for (int n = 0; n < 500; n++) {
                    std::vector<double> q(arm.joints);
                    for (std::size_t k = 0; k < q.size(); k++)
                        q[k] = 0.4 * std::sin(0.3 * n + 1.7 * double(k)) + (k == 1 ? -1.0 : k == 2 ? 0.9 : 0.3);
                    truepose_pose pose = arm.predict(q);
                    for (double &value : q) value += 0.01;
                    if (!arm.command(pose, q)) failures[t]++;
                    results[t].insert(results[t].end(), q.begin(), q.end());
                }
            });
        for (auto &thread : threads) thread.join();
        bool equal = true;
        int failed = 0;
        for (int t = 0; t < 4; t++) {
            equal = equal && results[t] == results[0];
            failed += failures[t];
        }
        std::printf("4 threads, 2000 commands, %d not reached; %s\n", failed,
                    equal ? "all threads agree to the last bit" : "the threads differ");
        return equal && failed == 0 ? 0 : 1;
    } catch (const std::exception &error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
