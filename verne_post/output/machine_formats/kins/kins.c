/* Kinematics component for LinuxCNC 2.9 and 2.10: sudo halcompile --install FILE.c, beside machine.h, model.h and carrier.h.
 *
 * Types of motion.switchkins-type: 0 tool-centre-point control (the world is the part on the table), 1 joints (x, y,
 * z, a, c are the five joints). Pins of the component:
 *     tool-offset      float in   tool length, mm; from motion.tooloffset.z
 *     newton           bit in     Newton's method from the last solution instead of the closed form
 *     refused          u32 out    world poses that the machine cannot reach, so far
 *     type-tcp, type-joints  bit out
 *     jacobian.enable  bit in     keep the pins below up to date with every inverse solution
 *     jacobian.J.x ... float out  rate of joint J by x, y, z (mm), a, c (degrees) of the world
 */
#include <float.h>
#include <math.h>

#include "rtapi.h"
#include "rtapi_app.h"
#include "hal.h"
#include "kinematics.h"

#include "model.h"

MODULE_LICENSE("MIT");

static struct {
    hal_float_t *tool_offset;
    hal_bit_t *newton, *type_tcp, *type_joints, *jacobian_enable;
    hal_u32_t *refused;
    hal_float_t *jacobian[5][5];
} *pins;

static int comp_id, type;
static struct memory of_inverse, of_forward;

int kinematicsForward(const double *joint, EmcPose *world, const KINEMATICS_FORWARD_FLAGS *fflags, KINEMATICS_INVERSE_FLAGS *iflags)
{
    struct pose found;
    (void)fflags;
    (void)iflags;
    if (type == 1) {
        found.x = joint[0], found.y = joint[1], found.z = joint[2], found.a = joint[3], found.c = joint[4];
    } else if (model_forward(joint, *pins->tool_offset, *pins->newton ? NEWTON : CLOSED_FORM, &of_forward, &found)) {
        return -1;
    }
    world->tran.x = found.x;
    world->tran.y = found.y;
    world->tran.z = found.z;
    world->a = found.a;
    world->c = found.c;
    world->b = world->u = world->v = world->w = 0.0;
    return 0;
}

int kinematicsInverse(const EmcPose *world, double *joint, const KINEMATICS_INVERSE_FLAGS *iflags, KINEMATICS_FORWARD_FLAGS *fflags)
{
    const struct pose asked = {world->tran.x, world->tran.y, world->tran.z, world->a, world->c};
    double rates[5][5];
    int i, j;
    (void)fflags;
    (void)iflags;
    if (type == 1) {
        joint[0] = asked.x, joint[1] = asked.y, joint[2] = asked.z, joint[3] = asked.a, joint[4] = asked.c;
        return 0;
    }
    if (model_inverse(&asked, *pins->tool_offset, *pins->newton ? NEWTON : CLOSED_FORM, &of_inverse, joint)) {
        *pins->refused += 1;
        return -1;
    }
    if (*pins->jacobian_enable && !model_jacobian(&asked, *pins->tool_offset, &of_inverse, rates))
        for (i = 0; i < 5; i++)
            for (j = 0; j < 5; j++)
                *pins->jacobian[i][j] = rates[i][j];
    return 0;
}

int kinematicsHome(EmcPose *world, double *joint, KINEMATICS_FORWARD_FLAGS *fflags, KINEMATICS_INVERSE_FLAGS *iflags)
{
    *fflags = 0;
    *iflags = 0;
    return kinematicsForward(joint, world, fflags, iflags);
}

KINEMATICS_TYPE kinematicsType(void)
{
    return KINEMATICS_BOTH;
}

int kinematicsSwitchable(void)
{
    return 1;
}

int kinematicsSwitch(int asked)
{
    if (asked != 0 && asked != 1)
        return -1;
    type = asked;
    *pins->type_tcp = type == 0;
    *pins->type_joints = type == 1;
    of_inverse.known = of_forward.known = 0;
    return 0;
}

EXPORT_SYMBOL(kinematicsForward);
EXPORT_SYMBOL(kinematicsInverse);
EXPORT_SYMBOL(kinematicsHome);
EXPORT_SYMBOL(kinematicsType);
EXPORT_SYMBOL(kinematicsSwitchable);
EXPORT_SYMBOL(kinematicsSwitch);

static int make_pins(void)
{
    static const char letters[5] = "xyzac";
    int i, j, failed;
    pins = hal_malloc(sizeof(*pins));
    if (!pins)
        return -1;
    failed = hal_pin_float_newf(HAL_IN, &pins->tool_offset, comp_id, KINS_NAME ".tool-offset")
        || hal_pin_bit_newf(HAL_IN, &pins->newton, comp_id, KINS_NAME ".newton")
        || hal_pin_u32_newf(HAL_OUT, &pins->refused, comp_id, KINS_NAME ".refused")
        || hal_pin_bit_newf(HAL_OUT, &pins->type_tcp, comp_id, KINS_NAME ".type-tcp")
        || hal_pin_bit_newf(HAL_OUT, &pins->type_joints, comp_id, KINS_NAME ".type-joints")
        || hal_pin_bit_newf(HAL_IN, &pins->jacobian_enable, comp_id, KINS_NAME ".jacobian.enable");
    for (i = 0; i < 5; i++)
        for (j = 0; j < 5; j++)
            failed = failed || hal_pin_float_newf(HAL_OUT, &pins->jacobian[i][j], comp_id, KINS_NAME ".jacobian.%d.%c", i, letters[j]);
    if (failed)
        return -1;
    return kinematicsSwitch(0);
}

int rtapi_app_main(void)
{
    comp_id = hal_init(KINS_NAME);
    if (comp_id < 0)
        return comp_id;
    if (make_pins()) {
        hal_exit(comp_id);
        return -1;
    }
    return hal_ready(comp_id);
}

void rtapi_app_exit(void)
{
    hal_exit(comp_id);
}
