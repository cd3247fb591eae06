// The table as the camera shows it, darkened by the shadows of sand and objects (runtime/shadow/README.md). It is drawn
// before what stands on it. Where an AROcclusionManager has written the depth of what is real, that hides it: so all is drawn
// nearer to the eye by the same share, where it stays on its pixels, and only what is higher than `bias` hides what lies on
// the table. Colours are linear, and so must be the project's colour space.
Shader "Sandglass/Table" {
  SubShader {
    Tags { "RenderType" = "Transparent" "Queue" = "Geometry-10" }
    Blend SrcAlpha OneMinusSrcAlpha
    ZWrite Off
    Cull Off
    Pass {
      CGPROGRAM
      #pragma target 4.5
      #pragma vertex vertex
      #pragma fragment fragment
      #include "UnityCG.cginc"

      Texture2D<float> _Object, _ObjectRoom, _Sand, _SandRoom;
      SamplerState linear_clamp_sampler;
      float4 _ObjectBox, _ObjectRoomBox, _SandBox, _SandRoomBox;  // a corner, and one over the extents; 0: there is none
      float3 _Origin;  // in Unity's world
      float _HalfSide, _MainShare, _SandOpacity, _Nearer;

      struct Corner { float4 position : SV_POSITION; float2 place : TEXCOORD0; };

      Corner vertex(uint index : SV_VertexID) {
        static const float2 corners[6] = { float2(-1, -1), float2(1, -1), float2(1, 1), float2(-1, -1), float2(1, 1), float2(-1, 1) };
        Corner corner;
        corner.place = _HalfSide * corners[index];
        float4 view = mul(UNITY_MATRIX_V, float4(_Origin + float3(corner.place.x, 0, -corner.place.y), 1));  // right-handed to left-handed
        corner.position = mul(UNITY_MATRIX_P, float4(view.xyz * _Nearer, 1));
        return corner;
      }

      float at(Texture2D<float> map, float4 box, float2 place, float outside) {
        float2 p = (place - box.xy) * box.zw;
        return box.z > 0 && all(p == saturate(p)) ? map.Sample(linear_clamp_sampler, p) : outside;
      }

      fixed4 fragment(Corner corner) : SV_Target {
        float s = _MainShare;
        float sharp = (1 - at(_Object, _ObjectBox, corner.place, 0)) * (1 - _SandOpacity * at(_Sand, _SandBox, corner.place, 0));
        float rest = max(at(_ObjectRoom, _ObjectRoomBox, corner.place, 1) - s, 0) * max(at(_SandRoom, _SandRoomBox, corner.place, 1) - s, 0);
        return fixed4(0, 0, 0, 1 - (s * sharp + (s < 1 ? rest / (1 - s) : 0)));
      }
      ENDCG
    }
  }
}
